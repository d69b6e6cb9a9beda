"""A robot in Bullet."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from handcart.backends.backend import NoWindow
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel

from .bullet_body import BulletBody
from .bullet_camera import BulletCamera, looking, render
from .bullet_engine import BulletEngine

_VIEW_SIZE = (640, 480)
_VIEW_K = np.array([[520.0, 0.0, 319.5], [0.0, 520.0, 239.5], [0.0, 0.0, 1.0]])
_VIEW_FROM, _VIEW_TO = np.array([-1.3, 1.3, 2.0]), np.array([0.5, -0.1, 0.6])  # in the frame `base` [m]


class PyBulletBackend(PhysicsBackend):
    """See `PhysicsBackend`.

    How it differs from metal: links are rigid, a floor is flat, friction is Coulomb's, one coefficient for
    a pair, light has no shadows.
    """

    name = "pybullet"
    _engine: BulletEngine

    def _start_engine(self, window: bool) -> BulletEngine:
        return BulletEngine(self.period, window)

    def _load_robot(self, robot: RobotFile) -> BulletBody:
        return BulletBody(self._engine, robot, self.scene.base)

    def _make_camera(self, spec: CameraSpec, arm: ArmModel) -> BulletCamera:
        return BulletCamera(self._robot, spec, arm, self._body, self._world, self._engine, self._seed)

    @classmethod
    def build_in_window(cls, robot: RobotFile, world: Path | WorldFile | None, seed: int) -> PyBulletBackend:
        """See `Backend`."""
        if sys.platform == "linux" and not os.environ.get("DISPLAY"):
            raise NoWindow(
                "there is no display to show a window on: $DISPLAY is not set; allowed: --video FILE.mp4"
            )
        return cls(robot, cls.needed(world), seed, window=True)

    def view(self) -> NDArray[np.uint8]:
        """See `Backend`."""
        return render(self._engine, self._beside(), _VIEW_K, _VIEW_SIZE, lit=True)

    def _beside(self) -> Transform:
        """world_T_camera (4, 4) of somebody behind the robot, to its left, on this side of walls."""
        world_T_base = self._body.base_pose()
        eye, middle = ((world_T_base @ (*point, 1.0))[:3] for point in (_VIEW_FROM, _VIEW_TO))
        free = self._engine.free_share(middle, eye)
        return looking(middle + (0.95 if free < 1.0 else 1.0) * free * (eye - middle), middle)
