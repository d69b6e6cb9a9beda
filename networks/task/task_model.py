"""Contents of a task file."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, create_model, model_validator

from handcart.files.models.model import FileModel
from handcart.networks.graph.network import MAX_ATTEMPTS, MAX_COST_S, Fact
from handcart.primitives.knowledge.map_masks import SpeedMask
from handcart.tasks.domain import domains

MAX_TASK_BYTES = 1 << 24
MAX_TASK_NODES = 1_000_000
"""Limits of a task's file, which may be generated: some 50,000 actions."""


class GeneralFiles(FileModel):
    """Prior knowledge of the robot: files next to the task's."""

    map: str | None = None
    """A map in ROS format, or a `.map` of MovingAI; `none`: places are relative to the start."""
    keepout: str | None = None
    """A mask in ROS format over the map (nav2's keepout filter): no way leads where it is occupied."""
    speed_limits: SpeedMask | None = None
    """A mask over the map (nav2's speed filter): how fast the base may drive where."""
    places: str | None = None
    """The map's named places, or goals as users of nav2 keep them."""
    start: str | None = None
    """The place of the robot at first, or `unknown`: LOCATE then finds it (default: the map's origin)."""


def _with_domains() -> type[GeneralFiles]:
    """Return the model with the keys that domains add."""
    keys: dict[str, Any] = {
        key: (str | None, Field(None, description=words))
        for domain in domains()
        for key, words in (domain.knowledge.files if domain.knowledge else {}).items()
    }
    return create_model("KnowledgeFiles", __base__=GeneralFiles, __doc__=GeneralFiles.__doc__, **keys)


if TYPE_CHECKING:
    KnowledgeFiles = GeneralFiles
else:
    KnowledgeFiles = _with_domains()


Probability = Annotated[float, Field(ge=0.0, le=1.0)]
Count = Annotated[int, Field(ge=1, le=MAX_ATTEMPTS)] | Literal["unlimited"]


class ThenEntry(FileModel):
    """A situation that Success may lead to."""

    target: Annotated[str, Field(alias="to")]
    """The situation."""
    p: Probability | None = None
    """Probability that an attempt ends so."""
    result: str = ""
    """Result by which the primitive reports it (default: the usual one)."""


class AttemptsEntry(FileModel):
    """Limit on the Fails of an action."""

    most: Count = 3
    """Maximum number of Fails, or `unlimited`."""
    budget: str | None = None
    """Name of one of the task's `budgets`, shared with all actions that name it."""
    shared: bool = False
    """True if the copies of the action in a repeat share its attempts."""
    fresh_after: str | list[str] = Field(default_factory=list)
    """Primitives after whose Success the Fails are forgotten, in a repeat for the same element."""
    renewals: Annotated[int, Field(ge=1, le=MAX_ATTEMPTS)] = 3
    """How often they are forgotten, at most."""


class FailEntry(FileModel):
    """Result of a Fail of a certain cause: the situation that it leads to."""

    to: str | None = None
    """The situation: same facts, other knowledge (default: it remains as it is)."""
    p: Probability | None = None
    """Probability that an attempt fails so."""


OTHER_CAUSES = "else"
"""Key for the causes that are not named."""


class ActionEntry(FileModel):
    """An action in a task file."""

    do: str
    """Name of the primitive."""
    source: Annotated[str, Field(alias="from")]
    """The situation in which it can be done."""
    to: str = ""
    """The situation that Success leads to; `then` if there are several."""
    then: Annotated[list[ThenEntry], Field(min_length=1)] | None = None
    """The situations that Success may lead to, the usual one first."""
    fails: Annotated[str | dict[str, str | FailEntry] | None, Field(alias="on_fail")] = None
    """The situation that Fail leads to: same facts, other knowledge (default: Fail changes nothing); or one
    for each cause, and `else`.
    """
    cost_s: Annotated[float, Field(gt=0.0, le=MAX_COST_S)]
    """Expected duration; each Fail doubles its weight in planning."""
    attempts: Count | AttemptsEntry = 3
    """Maximum number of Fails, after which it is excluded; or how they are counted."""
    p: Annotated[float, Field(gt=0.0, le=1.0)] | None = None
    """Probability that an attempt ends in Success; `handcart check` then reports how runs end."""
    p_give_up: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    """Probability that it ends in GiveUp; the rest is that of Fail."""
    permit: Literal["operator"] | None = None
    """`operator`: it starts only when the operator permits it, each time."""
    time_out_s: Annotated[float, Field(gt=0.0, le=MAX_COST_S)] | None = None
    """Time limit of the motion; after that it is stopped, restored, and counts as a Fail."""
    parameters: Annotated[dict[str, Any], Field(alias="with", default_factory=dict)]
    """The primitive's parameters; `{model: cup.size}` is looked up when the action starts, `{each: slot}`
    is the element of a repeat."""

    @model_validator(mode="after")
    def _leads_somewhere(self) -> Self:
        if self.then is None and not self.to:
            raise ValueError("the key 'to' is missing; needed: the situation that Success leads to")
        if self.then is not None and self.to:
            raise ValueError("has both `to` and `then`; allowed: one of them")
        if self.then is not None and self.p is not None:
            raise ValueError("has both `p` and `then`; allowed: p in each entry of `then`")
        return self

    @property
    def target(self) -> str:
        """The situation that Success usually leads to."""
        return self.then[0].target if self.then else self.to

    @cached_property
    def endings(self) -> list[ThenEntry]:
        """The situations that Success may lead to, the usual one first."""
        return self.then or [ThenEntry.model_construct(target=self.to, p=self.p, result="")]

    @property
    def leads_to(self) -> list[str]:
        """All situations that the action may lead to, that of a Fail last."""
        return [*(each.target for each in self.endings), *self.fail_situations]

    @property
    def on_fail(self) -> str | None:
        """Situation that a Fail leads to if its cause has none of its own; None: the situation stays."""
        if isinstance(self.fails, str):
            return self.fails
        named = self._by_cause.get(OTHER_CAUSES)
        return None if named is None else named.to

    @property
    def fail_entries(self) -> dict[str, FailEntry]:
        """Results of Fails, by the name of their cause."""
        return {cause: each for cause, each in self._by_cause.items() if cause != OTHER_CAUSES}

    @property
    def fail_situations(self) -> list[str]:
        """All situations that a Fail may lead to, that of causes without an entry last."""
        return [each for each in (*(e.to for e in self.fail_entries.values()), self.on_fail) if each]

    @property
    def _by_cause(self) -> dict[str, FailEntry]:
        if not isinstance(self.fails, dict):
            return {}
        return {
            cause: FailEntry(to=each) if isinstance(each, str) else each for cause, each in self.fails.items()
        }

    @property
    def p_success(self) -> float | None:
        """Probability of Success, with any target situation; None if it is not given."""
        every = [each.p for each in self.endings]
        return None if None in every else sum(p or 0.0 for p in every)

    @cached_property
    def limit(self) -> AttemptsEntry:
        """The limit on its Fails."""
        if isinstance(self.attempts, AttemptsEntry):
            return self.attempts
        return AttemptsEntry.model_construct(
            most=self.attempts, budget=None, shared=False, fresh_after=[], renewals=3
        )


class Each(FileModel):
    """A value of the element of a repeat."""

    each: str
    """NAME, or NAME.KEY."""


GivenFact = Fact | Each


class Repeat(FileModel):
    """A part of the network, copied for each element of a list, one copy after the other."""

    over: Annotated[list[Any], Field(min_length=1)] | Each
    """The elements; `{all: places}` is the list of the names of the map's places, in their file's order, and
    so on for other names in the task's files, such as `{all: cups}`. In a part within a part `{each:
    NAME.KEY}` is a list of the element around it.
    """
    name: Annotated[str, Field(alias="as")]
    """Name of the element in `{each: NAME}`."""
    start: str
    """The situation in which the part begins."""
    goal: str
    """The situation in which an element is done: where the next one's part begins."""
    unfinished: Literal["stop", "skip"] = "stop"
    """Effect of an element that cannot be done: it ends the run, or it is skipped if the facts are those of
    the part's start (the run then ends with status 3).
    """


class TaskFile(FileModel):
    """A task: situations, and the actions that lead from one to another."""

    format: Literal["handcart-task/1"]
    title: str
    """The task's purpose, in words."""
    robot: str
    """A shipped robot's name, or the path of a robot's YAML file."""
    world: str | None = None
    """The world that simulated backends build, unknown to the robot: a world's file, or a map in ROS format.
    With a map, its occupied cells are walls, and the robot starts where `knowledge` says.
    """
    backend: str = "kinematic"
    """The backend of the robot, unless the command line names another."""
    knowledge: KnowledgeFiles | None = None
    parameters: Annotated[dict[str, Any], Field(default_factory=dict)]
    """Values that `--set KEY=VALUE` may change; `{parameter: KEY}` refers to them anywhere in the file."""
    start: str
    """The situation at the start."""
    goal: str
    """The situation to be reached."""
    otherwise: str | list[str] | None = None
    """Situations to be reached when no route to the goal is left, in order of preference; the run then ends
    with status 3 all the same.
    """
    policy: Literal["rule", "expected_cost", "goal_probability"] = "rule"
    """How actions are chosen: the cheapest route with doubled weights, or by the probabilities `p` the least
    expected cost or the largest probability of the goal.
    """
    person_s: Annotated[float, Field(gt=0.0, le=1e6)] = 600.0
    """Price of each end short of the goal, in seconds of a person's time."""
    budgets: Annotated[dict[str, Annotated[int, Field(ge=1, le=MAX_ATTEMPTS)]], Field(default_factory=dict)]
    """Attempts that several actions share, by name; `attempts: {budget: NAME}` refers to them."""
    situations: dict[str, dict[str, GivenFact] | None]
    """Situations by name, each with the physical facts that hold in it.

    `{each: NAME.KEY}` is the element's own.
    """
    actions: list[ActionEntry]
    repeat: Annotated[list[Repeat], Field(min_length=1)] | Repeat | None = None
    """The repeated part, or a list of parts.

    Two of them have no common situation, or one is within the other.
    """
