"""What a survey may look at: a robot, what it knows, and the simulated world as it truly is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from handcart.backends.backend import Backend
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.networks.task.preparing import Prepared
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
