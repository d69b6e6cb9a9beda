"""Bench for a backend: the same robot in the same world, built again for each check."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

from handcart.backends.backend import Backend
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig

CapabilityT = TypeVar("CapabilityT", bound=Capability)


@dataclass(frozen=True)
class KitBench:
    """Backend under test, with the robot and the world in which the conformance kit tests it."""

    backend: str
    robot: str = "librarian"
    files: RigFiles = field(default_factory=RigFiles)
    liar: str | None = None
    """Mutant wrapped around the backend, by its name in `BACKEND_LIARS`; None for the backend as it is."""
    quick: bool = True
    simulated: str | None = None
    """Name of the simulated backend behind the drives or topics; None: the backend needs none."""

    def spec(self) -> RobotFile:
        """Return the robot's file as it is on disk, without changes that a check makes."""
        return load_robot(self.robot)

    def rig(self, seed: int = 0) -> Rig:
        """Return a new robot at its start in the world, on the backend under test."""
        rig = build_rig(self.files, self.robot, self.backend, seed, bench=self.simulated)
        if self.liar is None:
            return rig
        return self.around(rig, liar_around(self.liar, rig.backend, rig.robot.spec))

    def around(self, rig: Rig, backend: Backend) -> Rig:
        """Return a rig (robot, model and backend) that uses a wrapper of the given rig's backend.

        Args:
            rig: rig whose world and start are kept.
            backend: wrapper to use instead of the rig's backend.
        """
        start = rig.model.places[self.files.start].pose
        return Rig(Robot(backend, rig.robot.spec, start, rig.model.map), rig.model, backend)


def liar_around(name: str, backend: Backend, spec: RobotFile) -> Backend:
    """Wrap a backend in the mutant (deliberately faulty) backend called `name`, and return the wrapper."""
    from .backend_liars import BACKEND_LIARS

    return BACKEND_LIARS[name](backend, spec)
