"""What ground truth says of the outcomes of a domain's primitives, and what it may look at for that."""

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
from handcart.primitives.contract.outcome import Outcome
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.tasks.domain import Domain

if TYPE_CHECKING:
    from handcart.backends.simulation.scene import Scene


@dataclass(frozen=True)
class SurveyedRun:
    """A run that is surveyed, or a single attempt."""

    robot: Robot
    spec: RobotFile
    """The robot's file as it is at first: a calibration changes the robot's own."""
    model: WorldModel
    scene: Scene | None
    """The simulated world as it truly is; None where there is none."""
    seed: int = 0
    """Of the simulated errors."""
    does: frozenset[str] = frozenset()
    """Names of the primitives that it may come to."""
    folder: Path | None = None
    """Where a survey may keep notes; None: nowhere."""

    def concerns(self, domain: Domain) -> bool:
        """Whether it has to do with a domain: does, knows or has in its world anything of it."""
        there = self.scene is not None and domain.name in self.scene.props
        return there or domain.name in self.model.sections or bool(self.does & domain.primitives.keys())

    @property
    def world(self) -> Scene:
        """The same, for who has asked before whether there is one."""
        assert self.scene is not None, "nothing is simulated"
        return self.scene

    @classmethod
    def of(cls, prepared: Prepared, folder: Path | None = None) -> SurveyedRun:
        """A run of a task that hasn't started."""
        robot = prepared.robot
        does = frozenset(action.do for action in prepared.task.network.actions)
        scene = simulated_world(prepared.backend)
        return cls(robot, robot.spec, prepared.model, scene, prepared.seed, does, folder)


def simulated_world(backend: Backend) -> Scene | None:
    """What is behind a backend, through all that is put around it; None where no scene is simulated."""
    while backend.inner is not None:
        backend = backend.inner
    if not backend.simulated:
        return None
    from handcart.backends.simulation.simulated_backend import SimulatedBackend

    return backend.scene if isinstance(backend, SimulatedBackend) else None


class Claim(NamedTuple):
    """A Success that is held against the ground truth."""

    primitive: Any
    """The `ActionPrimitive` that claims it."""
    before: GroundTruth
    after: GroundTruth


Effect = Callable[[Any, Claim], list[str]]
"""What a Success of a primitive promises and isn't so, in words; gets the survey, and the claim."""


class Survey(ABC):
    """Looks at a run from outside: it changes nothing, and sees what no primitive may see.

    One that raises is left out from then on, and `untrue` says so: the run itself goes on.
    """

    name: ClassVar[str]
    """Under which its notes are kept; the domain's, say."""
    effects: ClassVar[Mapping[str, Effect]] = {}
    """By name of the primitive: what its Success promises and isn't so. What a primitive disturbs beside what
    it holds, and beside what its `meant_contacts` name for the hand, is found without that."""
    noted: ClassVar[Any] = None
    """Type of what `notes` gives: numbers, words, lists, mappings, dataclasses of them. None: no notes."""
    limits: ClassVar[Mapping[str, float]] = {}
    """By name of a figure: the most that it may be where a whole run's Success is true."""
    shown: ClassVar[frozenset[str]] = frozenset()
    """Primitives whose pictures a run's overview shows before others'."""

    def __init__(self, run: SurveyedRun) -> None:
        """Of a run that hasn't started, or goes on."""
        self.run = run

    @classmethod
    def applies(cls, run: SurveyedRun) -> bool:
        """Whether it has anything to look at: a simulated world, and one of its primitives."""
        return run.scene is not None and bool(run.does & cls.effects.keys())

    def started(self, number: int, primitive: ActionPrimitive) -> None:
        """An action with that number starts."""

    def look(self, robot: Robot) -> None:
        """A period has passed."""

    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        """An action has ended; gives what more of its outcome isn't so, in words."""
        return []

    def notes(self) -> Any:
        """What a run that breaks off now couldn't tell again, of the type `noted`."""

    def go_on(self, noted: Any) -> None:
        """Take up the last notes of the run that this one goes on with: of the type `noted`, else anything.

        Raises:
            ValueError: they can't be of such a run.
        """

    @abstractmethod
    def figures(self) -> Mapping[str, Any]:
        """For the metrics of a run that has ended."""

    def faults(self) -> list[str]:
        """What the Success of a whole run claims and isn't so, in words."""
        return []

    def report(self, prepared: Prepared, folder: Path) -> None:
        """Write what others read on, into the folder of a run that has ended.

        Raises:
            OSError: the disk takes no more.
        """

    def draw(self, folder: Path) -> None:
        """Draw pictures into the folder of a run that has ended; its page shows each `*.svg`.

        Raises:
            OSError: the disk takes no more.
        """


class FiguresSurvey(Survey):
    """Fills `_figures` in a run, by the names that they have in its metrics."""

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
