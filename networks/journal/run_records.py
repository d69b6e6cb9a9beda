"""Types of the records of a run's journal, by their kind: used for writing, and relied on when reading."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NotRequired

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError, with_config
from typing_extensions import TypedDict

_OPEN = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)

Number = Annotated[int, Field(ge=1, lt=2**31)]
"""Number of an action of the run, from 1."""
Index = Annotated[int, Field(ge=0, lt=2**31)]
Pose = Annotated[list[float], Field(min_length=3, max_length=3)]
Joints = Annotated[list[float], Field(max_length=64)]
Sizes = dict[str, float | None]


@with_config(_OPEN)
class At(TypedDict):
    """Snapshot of the robot in a record: base, joints and gripper, in [m] and [rad].

    `base` is x, y and heading, `base_sigma` the sigma of position and heading; null is unknown.
    """

    base: Pose
    base_sigma: Annotated[list[float | None], Field(min_length=2, max_length=2)]
    joints: NotRequired[Joints]
    joint_command: NotRequired[Joints]
    grip: NotRequired[float]
    grip_command: NotRequired[float]
    holding: NotRequired[bool]


@with_config(_OPEN)
class Run(TypedDict):
    """Header of a run's journal, with task, robot and options; only `handcart run` writes all its fields."""

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
class PlannedRecord(TypedDict):
    """Record of a plan, or of the reason why no plan was found."""

    situation: str
    way: NotRequired[list[Index]]
    cost: NotRequired[float]
    no_way: NotRequired[str]
    excluded: NotRequired[list[Index]]
    judged: NotRequired[dict[str, Any]]
    error: NotRequired[str]


ActionWords = TypedDict(
    "ActionWords", {"index": Index, "do": str, "from": str, "to": str, "with": NotRequired[dict[str, Any]]}
)


@with_config(_OPEN)
class StartRecord(TypedDict):
    """Record of an action that is about to start, with its number in the run and, if measured, a snapshot of
    the robot.
    """

    n: Number
    action: ActionWords
    at: NotRequired[At]


@with_config(_OPEN)
class CauseWords(TypedDict):
    """Record of why an attempt did not succeed, with a text, the kind of cause, and the deciding reading."""

    reason: str
    kind: NotRequired[str]
    """Kind of cause; missing in journals of older versions."""
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
    """Record of an action that ended in Success."""

    outcome: Literal["Success"]
    result: NotRequired[str]
    """Measured result, one of the primitive's `results`; missing for the usual one."""


class Failed(_Result):
    """Record of an action that ended in Fail, with the reason; a permanent Fail used up all attempts."""

    outcome: Literal["Fail"]
    reason: str
    permanent: bool
    by: NotRequired[Literal["recon"]]
    """Of an action that was broken off: a resume of the run measured the robot where the action began."""
    stays: NotRequired[bool]
    """True: the situation stays, whatever `on_fail` names; missing in journals of older versions, which
    followed `on_fail` after an action that was broken off, too.
    """


class GivenUp(_Result):
    """Record of an action that ended in GiveUp, with the reason."""

    outcome: Literal["GiveUp"]
    reason: str


Result = Succeeded | Failed | GivenUp


@with_config(_OPEN)
class Recon(TypedDict):
    """Record of a change of the world between two actions, detected by the run or reported by a person."""

    situation: str | None
    reason: NotRequired[str]
    action: NotRequired[Index]
    expected: NotRequired[At | None]
    at: NotRequired[At]
    residuals: NotRequired[Sizes]


@with_config(_OPEN)
class EndRecord(TypedDict):
    """Record: the run has ended, with its outcome, its last situation and the reason."""

    outcome: Literal["Success", "Fail", "GiveUp", "Cancelled", "Error"]
    situation: str
    reason: str
    at: NotRequired[At]


@with_config(_OPEN)
class Intent(TypedDict):
    """Record that an effect on the world is about to begin which cannot simply be repeated, such as opening
    the hand.
    """

    n: Number
    effect: str


@with_config(_OPEN)
class PointOfNoReturn(TypedDict):
    """Record that the running action passes a point after which it cannot be undone."""

    n: Number
    what: str


@with_config(_OPEN)
class StopRecord(TypedDict):
    """Record of a stop that was commanded to the robot on request, with its cause.

    The times of the request and of the command are in [s] of the robot's time.
    """

    cause: str
    asked_s: float
    sent_s: float


@with_config(_OPEN)
class Restore(TypedDict):
    """Journal's record that the running action begins to restore the state in which it found the robot."""

    n: Number
    reason: str


@with_config(_OPEN)
class NotStartedRecord(TypedDict):
    """Record of an action that could not be started."""

    action: Index
    reason: str
    cause: NotRequired[str]
    """Name of the cause's kind; missing if it has none, and in journals of older versions."""


@with_config(_OPEN)
class Skip(TypedDict):
    """Record of an element of a list that the run leaves undone, in a part of the task that is done for each
    element.
    """

    action: Index
    element: str


@with_config(_OPEN)
class Aim(TypedDict):
    """Journal's record of a change of the run's aim.

    The run may pursue another goal, begin another round of a task that is repeated, or wait for the next
    round.
    """

    what: Literal["abandon", "interrupt", "round", "wait"]
    """The goal is abandoned, an interrupt comes first, another round begins, or the round waits."""
    situation: str
    reason: NotRequired[str]
    interrupt: NotRequired[Index]
    """Number of the interrupt, from 0."""
    goal: NotRequired[str]
    """Situation that is pursued; missing if no route leads to the interrupt's goal."""
    round: NotRequired[Number]
    at_s: NotRequired[float]
    """The robot's time at which the round may begin, in [s]."""


@with_config(_OPEN)
class Acknowledgement(TypedDict):
    """Record: a person has taken care of the cause that another record describes."""

    record: Index
    of: str
    cause: NotRequired[str]
    reason: str
    stays: NotRequired[bool]
    """True: the situation stays as it was before the action; missing in journals of older versions, which
    followed `on_fail`.
    """


@with_config(_OPEN)
class Epoch(TypedDict):
    """Record that a new process has resumed the run."""

    after: Annotated[int, Field(ge=-1)]
    in_doubt: Number | None


@with_config(_OPEN)
class _Wall(TypedDict):
    unix_s: float
    boot_id: NotRequired[str | None]
    checkpoint: NotRequired[str]


@with_config(_OPEN)
class _Common(TypedDict):
    t: float
    wall: _Wall


RECORD_VALIDATORS: dict[str, TypeAdapter[Any]] = {
    "RUN": TypeAdapter(Run),
    "PLAN": TypeAdapter(PlannedRecord),
    "START": TypeAdapter(StartRecord),
    "INTENT": TypeAdapter(Intent),
    "PNR": TypeAdapter(PointOfNoReturn),
    "STOP": TypeAdapter(StopRecord),
    "RESTORE": TypeAdapter(Restore),
    "RESULT": TypeAdapter(Annotated[Result, Field(discriminator="outcome")]),
    "RECON": TypeAdapter(Recon),
    "NOT_STARTED": TypeAdapter(NotStartedRecord),
    "SKIP": TypeAdapter(Skip),
    "AIM": TypeAdapter(Aim),
    "END": TypeAdapter(EndRecord),
    "ACK": TypeAdapter(Acknowledgement),
    "EPOCH": TypeAdapter(Epoch),
}
"""Validators of the minimum content of a record, by its kind."""

_COMMON = TypeAdapter(_Common)


def makes_sense(record: dict[str, Any]) -> str:
    """Return what is wrong with a record read from a journal, as text; empty if the record is valid."""
    kind = RECORD_VALIDATORS.get(record["kind"]) if isinstance(record["kind"], str) else None
    if kind is None:
        return f"no such kind; allowed: {', '.join(RECORD_VALIDATORS)}"
    if (record["kind"] == "RUN") is not (record["q"] == 0):
        return "a journal begins with RUN, and has one"
    try:
        _COMMON.validate_python(record)
        kind.validate_python(record)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        return f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
    return ""
