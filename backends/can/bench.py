"""Wheels on a test stand."""

from __future__ import annotations

from backends.can_spec import CanSpec
from backends.robot_file import RobotFile
from backends.scene.world_file import WorldFile

from .driven_scene import DrivenScene
from .simulated_drives import SimulatedDrives


class Bench:
    """Simulated drives of both wheels; with a world, what they roll drives a base through it."""

    def __init__(self, robot: RobotFile, spec: CanSpec, world: WorldFile | None, seed: int) -> None:
        """Set it up.

        Args:
            robot: its file.
            spec: the section `can` of that file.
            world: None: the wheels turn in the air.
            seed: of how the robot errs in the world.
        """
        self._wheels = [(each.node, each.counts_per_m(robot.drive.wheel_radius_m)) for each in spec.wheels]
        self._rolled = [0.0, 0.0]
        self.driven = None if world is None else DrivenScene(robot, world, seed)
        """The world; None without one."""
        self.drives = SimulatedDrives(*(each.node for each in spec.wheels))
        """The drives: tests let them fail."""

    def advance(self, period: int) -> None:
        """Move the base by what the wheels have rolled since the last time; `period` is the current one."""
        rolled = [self.drives.nodes[node].position / counts_per_m for node, counts_per_m in self._wheels]
        left, right = (now - before for now, before in zip(rolled, self._rolled, strict=True))
        self._rolled = rolled
        if self.driven is not None:
            self.driven.advance(left, right, period)

    def close(self) -> None:
        """Let go of the bus. A second call does nothing."""
        self.drives.close()
