"""A robot in Bullet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.display import needs_display
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.robotics.numerics.arrays import ByteArray

from .bullet_body import BulletBody
from .bullet_camera import render
from .bullet_engine import BulletEngine

_VIEW_SIZE = (960, 540)  # [px]: Bullet's EGL renderer draws no more than 1024 x 768 at once
_VIEW_K = np.array([[750.0, 0.0, 479.5], [0.0, 750.0, 269.5], [0.0, 0.0, 1.0]])


class PyBulletBackend(PhysicsBackend):
    """Backend with the physics of PyBullet; see `PhysicsBackend`.

    Differences from hardware: links are rigid; a floor is flat; friction is Coulomb's, with a single
    coefficient for each pair of touching bodies; camera pictures have no shadows.
    """

    name = "pybullet"
    lacks = frozenset({"doors"})
    SIMULATIONS = ("pybullet", "physics", "scene")
    _engine: BulletEngine

    def _start_engine(self, window: bool) -> BulletEngine:
        return BulletEngine(self.period, window)

    def _load_robot(self, robot: RobotFile) -> BulletBody:
        return BulletBody(self._engine, robot, self.scene.base)

    @classmethod
    @override
    def build_in_window(cls, robot: RobotFile, world: Path | WorldFile | None, seed: int) -> PyBulletBackend:
        needs_display()
        return cls(robot, cls.needed(world), seed, window=True)

    @override
    def view(self) -> ByteArray:
        return render(self._engine, self._seen_from(), _VIEW_K, _VIEW_SIZE, lit=True)
