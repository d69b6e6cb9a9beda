"""Where a backend is tried: the same robot in the same world, built anew for each check."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

from handcart.backends.backend import Backend
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.robot_loading import load_robot
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.stage import Stage, StageFiles, set_stage

C = TypeVar("C", bound=Capability)


@dataclass(frozen=True)
class Bench:
    """A backend by its name, with the robot and the world that it is tried with."""

    backend: str
    robot: str = "librarian"
    files: StageFiles = field(default_factory=StageFiles)
    liar: str | None = None
    """A liar put around the backend, by its name in `backend_liars.LIARS`; None: the backend as it is."""
    quick: bool = True

    def spec(self) -> RobotFile:
        """The robot's file, as nobody has changed it."""
        return load_robot(self.robot)

    def stage(self, seed: int = 0) -> Stage:
        """A robot in the world, at its start."""
        stage = set_stage(self.files, self.robot, self.backend, seed)
        if self.liar is None:
            return stage
        return self.around(stage, liar_around(self.liar, stage.backend, stage.robot.spec))

    def around(self, stage: Stage, backend: Backend) -> Stage:
        """The same stage with another backend around its own."""
        start = stage.model.places[self.files.start].pose
        return Stage(Robot(backend, stage.robot.spec, start, stage.model.map), stage.model, backend)


def liar_around(name: str, backend: Backend, spec: RobotFile) -> Backend:
    """The liar with that name around a backend."""
    from handcart.evaluation.conformance.planted.backend_liars import LIARS

    return LIARS[name](backend, spec)
