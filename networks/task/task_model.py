"""Contents of a task file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, TypeAdapter, create_model

from handcart.files.models.model import FileModel
from handcart.networks.entries.action_entry import ActionEntry as ActionEntry
from handcart.networks.entries.aims_entry import AimsHead, ConditionInterrupt, SituationInterrupt
from handcart.networks.entries.condition_entry import ConditionEntry, Conditions, Values
from handcart.networks.graph.network import MAX_ATTEMPTS, Fact
from handcart.primitives.knowledge.map_masks import SpeedMask
from handcart.tasks.domain import domains

MAX_RESTORINGS = 10
MAX_TASK_BYTES = 1 << 24
MAX_TASK_NODES = 1_000_000
"""Limits of a task's file, which may be generated: some 50,000 actions."""


class GeneralFiles(FileModel):
    """Files with the robot's prior knowledge, such as the map and the places, which a task names."""

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


class RestoringEntry(FileModel):
    """Limits on further attempts to restore the state before an action, if a fault interrupts restoring."""

    attempts: Annotated[int, Field(ge=1, le=MAX_RESTORINGS)] = 1
    """Maximum number of tries before a person is called."""
    wait_s: Annotated[float, Field(ge=0.0, le=600.0)] = 5.0
    """Time at rest before it is tried again."""


class BeliefEntry(FileModel):
    """Weight of the file's outcome probabilities against the outcomes that a run observes itself."""

    attempts: Annotated[float, Field(ge=1.0, le=1e6)] = 20.0
    """Number of attempts that `p` of the file counts for, as if they had been seen before the run."""


class Each(FileModel):
    """Reference, in a part of the task that is copied for each element of a list, to that element or to a
    value in it.
    """

    each: str
    """NAME, or NAME.KEY."""


GivenFact = Fact | Each


class Repeat(FileModel):
    """Entry of a task file for a part of the network that is copied for each element of a list."""

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


class TaskHead(AimsHead):
    """Keys of every task file, whether its network is written out or generated from conditions."""

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
    policy: Literal["rule", "expected_cost", "goal_probability"] = "rule"
    """Choice of actions: the cheapest route with doubled weights, or by the probabilities `p` the least
    expected cost or the largest probability of the goal.
    """
    belief: BeliefEntry | None = None
    """Belief in the probabilities, which outcomes of the run change; policies but the rule follow it."""
    person_s: Annotated[float, Field(gt=0.0, le=1e6)] = 600.0
    """Price of each end short of the goal, in seconds of a person's time."""
    budgets: Annotated[dict[str, Annotated[int, Field(ge=1, le=MAX_ATTEMPTS)]], Field(default_factory=dict)]
    """Attempts that several actions share, by name; `attempts: {budget: NAME}` refers to them."""
    restoring: Annotated[RestoringEntry, Field(default_factory=RestoringEntry)]
    """Maximum number of attempts to undo an action after a fault, before it ends in GiveUp."""

    @property
    def belief_attempts(self) -> float | None:
        """Weight of the probabilities in the task's file, as a number of observed attempts of an action.

        The probabilities are the prior of the beliefs that a run updates by its outcomes. The weight is None
        if the run does not update its beliefs.
        """
        return None if self.belief is None or self.policy == "rule" else self.belief.attempts


class TaskFile(TaskHead):
    """Task file that lists its network explicitly, as situations and the actions that connect them."""

    start: str
    """The situation at the start."""
    goal: str | Annotated[list[str], Field(min_length=1, max_length=1000)]
    """The situation to be reached; a list is reached in its order."""
    interrupts: Annotated[list[SituationInterrupt], Field(default_factory=list)]
    """Goals that come first when a condition holds."""
    otherwise: str | list[str] | None = None
    """Situations to be reached when no route to the goal is left, in order of preference; the run then ends
    with status 3 all the same.
    """
    situations: dict[str, dict[str, GivenFact] | None]
    """Situations by name, each with the physical facts that hold in it.

    `{each: NAME.KEY}` is the element's own.
    """
    actions: list[ActionEntry]
    repeat: Annotated[list[Repeat], Field(min_length=1)] | Repeat | None = None
    """The repeated part, or a list of parts.

    Two of them have no common situation, or one is within the other.
    """


class ConditionFile(TaskHead):
    """Task file whose network is generated, from facts and from actions with conditions for their start."""

    facts: Annotated[dict[str, Values], Field(min_length=1)]
    """Physical facts by name, each with its possible values; the first one holds at the start."""
    known: Annotated[dict[str, Values], Field(default_factory=dict)]
    """Names of the robot's knowledge, each with its possible values; a Fail may change it."""
    start: Annotated[dict[str, Fact], Field(default_factory=dict)]
    """Facts at the start that are not the first of their values."""
    goal: Annotated[Conditions, Field(min_length=1)] | Annotated[list[Conditions], Field(min_length=1)]
    """Facts that are to hold in the end; a list is reached in its order."""
    interrupts: Annotated[list[ConditionInterrupt], Field(default_factory=list)]
    """Goals that come first when a condition holds."""
    otherwise: Conditions | list[Conditions] | None = None
    """Facts that are to hold when no route to the goal is left, or a list in order of preference; the run
    then ends with status 3 all the same.
    """
    actions: list[ConditionEntry]


AnyTaskFile = TaskFile | ConditionFile
"""Content of a task's file."""


def task_model() -> TypeAdapter[AnyTaskFile]:
    """Return the model of a task file, which is either a `TaskFile` or a `ConditionFile`."""
    return TypeAdapter(AnyTaskFile)
