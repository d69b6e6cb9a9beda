"""Interface of a survey: it compares the outcomes of a domain's primitives with the ground truth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.ground_truth import GroundTruth
from handcart.backends.robot.robot import Robot
from handcart.networks.task.preparing import Prepared
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes.outcome import Outcome
from handcart.robotics.geometry.pose2 import Pose2
from handcart.tasks.domain import Domain

if TYPE_CHECKING:
    from handcart.backends.simulation.world.scene import Scene


@dataclass(frozen=True)
class SurveyedRun:
    """Robot, world and other parts of a run, or of a single attempt, that a survey (evaluation) may read."""

    robot: Robot
    spec: RobotFile
    """The robot's file as loaded at first: a calibration changes the robot's own specification."""
    model: WorldModel
    scene: Scene | None
    """The true simulated world; None for a backend without a simulated scene."""
    seed: int = 0
    """Seed of the simulated errors."""
    does: frozenset[str] = frozenset()
    """Names of the primitives that the run may execute."""
    folder: Path | None = None
    """Folder for a survey's notes; None: no notes are kept."""

    def concerns(self, domain: Domain) -> bool:
        """Return whether the run uses an application domain.

        It does if it has the domain's primitives, knowledge or simulated things.
        """
        there = self.scene is not None and domain.name in self.scene.props
        return there or domain.name in self.model.sections or bool(self.does & domain.primitives.keys())

    @property
    def world(self) -> Scene:
        """Simulated scene of the run; only valid if `scene` is not None, which callers have to check."""
        assert self.scene is not None, "nothing is simulated"
        return self.scene

    @property
    def world_T_map(self) -> Pose2:
        """Pose of the robot's map in the world.

        A map that the robot is given has the frame of the world. If the robot draws its own map, its start
        pose determines the map's frame.
        """
        return self.world.world_T_map(self.robot.own_start)

    @property
    def base_on_map(self) -> Pose2:
        """True pose map_T_base of the base, in the frame of the robot's map."""
        base = self.world.base
        return base if self.robot.own_start is None else base.relative_to(self.world_T_map)

    @classmethod
    def of(cls, prepared: Prepared, folder: Path | None = None) -> SurveyedRun:
        """Return those components of a prepared run that surveys (observers that evaluate it) may read."""
        robot = prepared.robot
        does = frozenset(action.do for action in prepared.task.network.actions)
        scene = simulated_world(prepared.backend)
        return cls(robot, robot.spec, prepared.model, scene, prepared.seed, does, folder)


def simulated_world(backend: Backend) -> Scene | None:
    """Return the scene that a backend simulates, found through all its wrappers; None if it simulates no
    scene.
    """
    while backend.inner is not None:
        backend = backend.inner
    if not backend.simulated:
        return None
    from handcart.backends.simulation.simulated_backend import SimulatedBackend

    return backend.scene if isinstance(backend, SimulatedBackend) else None


class Claim(NamedTuple):
    """A primitive's Success, together with the ground truth before and after its action."""

    primitive: Any
    """The `ActionPrimitive` that reported the Success."""
    before: GroundTruth
    after: GroundTruth


Effect = Callable[[Any, Claim], list[str]]
"""Check of a Success: given the survey and the claim, it returns a message for each promise that is false."""


class Survey(ABC):
    """Base class of surveys, observers that evaluate a run by the ground truth and change nothing.

    A survey that raises an exception is removed for the rest of the run; the run continues. The exception is
    reported in the run's metric `untrue`, the list of outcomes that the ground truth contradicts.
    """

    name: ClassVar[str]
    """Key of its notes, for example the name of the domain."""
    effects: ClassVar[Mapping[str, Effect]] = {}
    """Checks of a primitive's Success, by name of the primitive.

    Disturbed bodies, other than those that the primitive holds or that its `meant_contacts` name for the
    hand, are found without such a check.
    """
    noted: ClassVar[Any] = None
    """Type that `notes` returns: numbers, strings, lists, mappings, dataclasses of them; None for no
    notes.
    """
    limits: ClassVar[Mapping[str, float]] = {}
    """Largest allowed value of a metric where the Success of a complete run is true, by name of the
    metric.
    """
    shown: ClassVar[frozenset[str]] = frozenset()
    """Primitives whose pictures are shown first in a run's overview."""

    def __init__(self, run: SurveyedRun) -> None:
        """Prepare to observe a run that is about to start or continue."""
        self.run = run

    @classmethod
    def applies(cls, run: SurveyedRun) -> bool:
        """Return whether the survey can check anything in a run.

        The run must have a simulated world and one of the primitives whose effects the survey checks.
        """
        return run.scene is not None and bool(run.does & cls.effects.keys())

    def started(self, number: int, primitive: ActionPrimitive) -> None:
        """Take note that an action starts, given its number in the run and its primitive; nothing by
        default.
        """

    def look(self, robot: Robot) -> None:
        """Observe the robot at the end of a control period, for checks and metrics of the survey; called
        every period.
        """

    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        """Return a message for each claim of an action's outcome that the ground truth contradicts.

        Claims that the checks in the class attribute `effects` cover are not included.
        """
        return []

    def notes(self) -> Any:
        """Return the observations that a continued run needs and cannot repeat.

        They are a value of the type that the class attribute `noted` names.
        """

    def go_on(self, noted: Any) -> None:
        """Restore the survey's observations from the interrupted run that this run continues.

        Args:
            noted: observations that `notes` returned last, of the type in the class attribute `noted`; any
                value if the attribute is None.

        Raises:
            ValueError: the observations cannot belong to the interrupted run.
        """

    @abstractmethod
    def figures(self) -> Mapping[str, Any]:
        """Return the survey's metrics of a run that has ended, by name."""

    def faults(self) -> list[str]:
        """Return a message for each way in which the Success of the complete run is false."""
        return []

    def report(self, prepared: Prepared, folder: Path) -> None:
        """Write files for other programs into the folder of a run that has ended.

        Raises:
            OSError: writing failed, for example because the disk is full.
        """

    def draw(self, folder: Path) -> None:
        """Draw pictures into the folder of a run that has ended; the page of the run's report shows each
        `*.svg`.

        Raises:
            OSError: writing failed, for example because the disk is full.
        """


class FiguresSurvey(Survey):
    """Base class of surveys (observers of a run) that only collect metrics, by name, in `_figures`."""

    noted = dict[str, float]

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self._figures: dict[str, float] = {}

    @override
    def notes(self) -> dict[str, float]:
        return self._figures

    @override
    def go_on(self, noted: dict[str, float]) -> None:
        self._figures = noted

    @override
    def figures(self) -> dict[str, Any]:
        return self._figures
