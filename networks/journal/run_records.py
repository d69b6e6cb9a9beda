"""What stands in the records of a run's journal, by their kind: the types that readers rely on."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NotRequired

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError, with_config
from typing_extensions import TypedDict

_OPEN = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)

Number = Annotated[int, Field(ge=1, lt=2**31)]
"""Which action of the run."""
Index = Annotated[int, Field(ge=0, lt=2**31)]
Pose = Annotated[list[float], Field(min_length=3, max_length=3)]
Joints = Annotated[list[float], Field(max_length=64)]
Sizes = dict[str, float | None]


@with_config(_OPEN)
class At(TypedDict):
    """How the robot stands."""

    base: Pose
    base_sigma: Annotated[list[float | None], Field(min_length=2, max_length=2)]
    joints: NotRequired[Joints]
    joint_command: NotRequired[Joints]
    grip: NotRequired[float]
    grip_command: NotRequired[float]
    holding: NotRequired[bool]


@with_config(_OPEN)
class Run(TypedDict):
    """The header; journals of other programs than `handcart run` may tell less."""

    schema: NotRequired[str]
    handcart: NotRequired[str]
    task: NotRequired[str]
    task_path: NotRequired[str]
    task_sha256: NotRequired[str]
    task_text: NotRequired[str]
    settings: NotRequired[dict[str, str]]
    network: NotRequired[str]
    start: NotRequired[str]
    robot: NotRequired[str]
    robot_sha256: NotRequired[str]
    backend: NotRequired[str]
    bench: NotRequired[str | None]
    simulated: NotRequired[bool]
    seed: NotRequired[Annotated[int, Field(ge=0, lt=2**63)]]
    errors: NotRequired[bool]


@with_config(_OPEN)
class Planned(TypedDict):
    """A plan, or that there is none."""

    situation: str
    way: NotRequired[list[Index]]
    cost: NotRequired[float]
    no_way: NotRequired[str]
    excluded: NotRequired[list[Index]]
    error: NotRequired[str]


ActionWords = TypedDict(
    "ActionWords", {"index": Index, "do": str, "from": str, "to": str, "with": NotRequired[dict[str, Any]]}
)


@with_config(_OPEN)
class Start(TypedDict):
    """An action is about to start."""

    n: Number
    action: ActionWords
    at: NotRequired[At]


@with_config(_OPEN)
class CauseWords(TypedDict):
    """Why an attempt didn't succeed."""

    reason: str
    check: NotRequired[str | None]
    calls: NotRequired[list[str]]
    measured: NotRequired[dict[str, Any] | None]
    fault: NotRequired[Any]
    restoring: NotRequired[bool]


@with_config(_OPEN)
class _Result(TypedDict):
    n: Number
    at: NotRequired[At]
    picture: NotRequired[str]
    learned: NotRequired[dict[str, Any]]
    evidence: NotRequired[dict[str, Any]]
    cause: NotRequired[list[CauseWords]]
    tolerance: NotRequired[Sizes]
    residuals: NotRequired[Sizes]


class Succeeded(_Result):
    """An action ended in Success."""

    outcome: Literal["Success"]


class Failed(_Result):
    """An action ended in Fail."""

    outcome: Literal["Fail"]
    reason: str
    permanent: bool


class GivenUp(_Result):
    """An action ended in GiveUp."""

    outcome: Literal["GiveUp"]
    reason: str


@with_config(_OPEN)
class Recon(TypedDict):
    """Somebody looked at the robot, or found the world changed."""

    situation: str | None
    reason: NotRequired[str]
    expected: NotRequired[At | None]
    at: NotRequired[At]
    residuals: NotRequired[Sizes]


@with_config(_OPEN)
class End(TypedDict):
    """The run has ended."""

    outcome: Literal["Success", "Fail", "GiveUp", "Cancelled", "Error"]
    situation: str
    reason: str
    at: NotRequired[At]


def _kind(name: str, **fields: Any) -> TypeAdapter[Any]:
    return TypeAdapter(with_config(_OPEN)(TypedDict(name, fields)))  # type: ignore[operator]


RECORDS: dict[str, TypeAdapter[Any]] = {
    "RUN": TypeAdapter(Run),
    "PLAN": TypeAdapter(Planned),
    "START": TypeAdapter(Start),
    "INTENT": _kind("Intent", n=Number, effect=str),
    "PNR": _kind("PointOfNoReturn", n=Number, what=str),
    "STOP": _kind("Stop", cause=str, asked_s=float, sent_s=float),
    "RESTORE": _kind("Restore", n=Number, reason=str),
    "RESULT": TypeAdapter(Annotated[Succeeded | Failed | GivenUp, Field(discriminator="outcome")]),
    "RECON": TypeAdapter(Recon),
    "NOT_STARTED": _kind("NotStarted", action=Index, reason=str),
    "SKIP": _kind("Skip", action=Index, element=str),
    "END": TypeAdapter(End),
    "ACK": _kind("Ack", record=Index, of=str, reason=str),
    "EPOCH": _kind("Epoch", after=Annotated[int, Field(ge=-1)], in_doubt=Number | None),
}
"""By kind, what a record of it holds at least."""

_COMMON = _kind("Common", t=float, wall=dict[str, Any])
_WALL = _kind("Wall", unix_s=float, boot_id=NotRequired[str | None], checkpoint=NotRequired[str])


def makes_sense(record: dict[str, Any]) -> str:
    """What is wrong in a record; empty where it can be relied on."""
    kind = RECORDS.get(record["kind"]) if isinstance(record["kind"], str) else None
    if kind is None:
        return f"no such kind; allowed: {', '.join(RECORDS)}"
    if (record["kind"] == "RUN") is not (record["q"] == 0):
        return "a journal begins with RUN, and has one"
    try:
        _COMMON.validate_python(record)
        _WALL.validate_python(record["wall"])
        kind.validate_python(record)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        return f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
    return ""
