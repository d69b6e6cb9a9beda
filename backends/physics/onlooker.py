"""Chase camera that follows the robot."""

from __future__ import annotations

import numpy as np

from handcart.backends.physics.engine.engine import Engine
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

FROM, TOWARDS = np.array([-1.5, 1.6, 1.75]), np.array([0.45, -0.1, 0.55])
"""Position of the camera and point that it looks at, (3,) each in the base frame, in [m]."""
FOLLOWING_TIME_S = 0.8  # time constant of following the robot
_BEFORE = 0.95  # share of the way to an obstacle between camera and robot
_FAR = 2.0  # [m] from the wanted position, beyond which the camera jumps there


class Onlooker:
    """Chase camera for videos, behind the robot and to its left.

    It follows the robot smoothly, and moves closer if something is between camera and robot.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._eye = self._at = np.full(3, np.inf)
        self._time = 0.0

    def look(self, world_T_base: Transform, time: float) -> Transform:
        """Return world_T_camera (4, 4) of the chase camera (z forward, x right, y down).

        Args:
            world_T_base: (4, 4) pose of the base.
            time: simulated time, in [s].
        """
        eye, at = ((world_T_base @ (*point, 1.0))[:3] for point in (FROM, TOWARDS))
        share = 1.0 - float(np.exp(-max(0.0, time - self._time) / FOLLOWING_TIME_S))
        if not np.linalg.norm(self._eye - eye) < _FAR or time < self._time:
            share = 1.0
        self._time = time
        if share < 1.0:
            eye, at = self._eye + share * (eye - self._eye), self._at + share * (at - self._at)
        self._eye, self._at = eye, at
        free = float(self._engine.free_shares(at, eye[None])[0])
        return looking(at + (_BEFORE * free if free < 1.0 else 1.0) * (eye - at), at)

    @property
    def at(self) -> FloatArray:
        """Point (3,) in the world at which the chase camera looks, in [m]."""
        return self._at


def looking(eye: FloatArray, at: FloatArray) -> Transform:
    """Return the pose world_T_camera (4, 4) of a level camera at the point `eye` that looks at the point
    `at`.

    Args:
        eye: (3,) position of the camera in the world, in [m].
        at: (3,) point in the world at which the camera looks, in [m].
    """
    forward = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = eye
    return pose
