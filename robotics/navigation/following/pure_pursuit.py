"""Following a path with front steering: pure pursuit (Coulter, 1992)."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import BRAKING_SHARE
from handcart.robotics.numerics.arrays import FloatArray

SEARCH_AHEAD_M = 0.4  # [m] of path ahead in which the nearest point is looked for


class PurePursuit:
    """Pure pursuit controller, which steers a car towards a point of the path at a fixed distance ahead.

    If less of the path is left than this distance, the point is on a straight line that continues the path
    along its last heading. The car slows down before the end of the path.
    """

    def __init__(
        self,
        poses: FloatArray,
        ahead: float = 0.8,
        sharpest: float = 0.5,
        speed: float = 0.5,
        acceleration: float = 0.3,
    ) -> None:
        """Follow a path.

        Args:
            poses: (n, 3) poses along the path, in any frame, in [m, m, rad].
            ahead: distance to the point that is steered for, in [m].
            sharpest: curvature that the steering allows, in [1/m].
            speed: in [m/s].
            acceleration: in [m/s²], also for braking.
        """
        self._poses = np.asarray(poses)
        steps = np.hypot(*np.diff(self._poses[:, :2], axis=0).T)
        self._along = np.concatenate([[0.0], np.cumsum(steps)])
        self._ahead, self._sharpest = ahead, sharpest
        self._speed, self._acceleration = speed, acceleration
        self._at = 0

    @property
    def left(self) -> float:
        """Length of the path from the point that the car has reached to the path's end, in [m]."""
        return float(self._along[-1] - self._along[self._at])

    def command(self, pose: Pose2, speed: float, dt: float) -> tuple[float, float]:
        """Return speed in [m/s] and curvature in [1/m], positive to the left, for the next period.

        Args:
            pose: pose of the car now, in the frame of the path.
            speed: speed of the car now, in [m/s].
            dt: control period, in [s].
        """
        self.advance(pose)
        return self._pace(pose, speed, dt), self._steer(pose)

    def astray(self, pose: Pose2) -> float:
        """Return how far the car is off its path: its distance, in [m], from the path's point that it has
        reached.
        """
        return float(np.hypot(*(self._poses[self._at, :2] - pose[:2])))

    def advance(self, pose: Pose2) -> None:
        """Set the reached point of the path to the point nearest to the car.

        The reached point moves by at most `SEARCH_AHEAD_M` ahead, and never back.
        """
        end = int(np.searchsorted(self._along, self._along[self._at] + SEARCH_AHEAD_M, side="right"))
        away = np.hypot(*(self._poses[self._at : end, :2] - pose[:2]).T)
        self._at += int(np.argmin(away))

    def _pace(self, pose: Pose2, speed: float, dt: float) -> float:
        x, y, heading = self._poses[-1].tolist()
        near = math.cos(heading) * (x - pose.x) + math.sin(heading) * (y - pose.y)
        left = near if self.left < SEARCH_AHEAD_M else self.left
        if left <= 0.0:
            return 0.0
        stopping = math.sqrt(2.0 * BRAKING_SHARE * self._acceleration * left)
        return min(self._speed, speed + self._acceleration * dt, stopping, left / dt)

    def _steer(self, pose: Pose2) -> float:
        """Return the curvature in [1/m] of the arc to the point of the path `ahead` of the car."""
        target = int(np.searchsorted(self._along, self._along[self._at] + self._ahead))
        beyond = self._along[self._at] + self._ahead - self._along[-1]
        point = self._poses[min(target, len(self._poses) - 1)]
        x, y = point[0], point[1]
        if beyond > 0.0:
            x, y = x + beyond * math.cos(point[2]), y + beyond * math.sin(point[2])
        local = pose.inverse().apply(np.array([[x, y]])).reshape(2)
        reach = float(local @ local)
        bend = 2.0 * float(local[1]) / max(reach, 1e-6)
        return max(-self._sharpest, min(self._sharpest, bend))
