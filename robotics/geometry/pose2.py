"""Poses in the plane."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

MIN_QUATERNION = 1e-6  # squared length of a quaternion below which it is no turn


def heading_of(x: float, y: float, z: float, w: float) -> float:
    """Return the heading in [rad] of a quaternion of any length, in ROS's order; NaN for one that is no turn,
    such as the zeros of a message that was not filled in.
    """
    length = x * x + y * y + z * z + w * w
    if not MIN_QUATERNION < length < math.inf:
        return math.nan
    return math.atan2(2.0 * (w * z + x * y), length - 2.0 * (y * y + z * z))


def wrap(angle: float) -> float:
    """Return the angle wrapped to (-pi, pi], in [rad]."""
    return -((math.pi - angle) % (2.0 * math.pi) - math.pi)


class Pose2(NamedTuple):
    """A pose in the plane, SE(2): `x`, `y` in [m], `theta` in [rad].

    Named `a_T_b` it is the pose of b in a; `a_T_b.compose(b_T_c)` is `a_T_c`.
    """

    x: float
    y: float
    theta: float

    def compose(self, other: Pose2) -> Pose2:
        """Return a pose `other`, given in this pose's own frame, transformed to the frame in which this pose
        is given.
        """
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return Pose2(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            wrap(self.theta + other.theta),
        )

    def inverse(self) -> Pose2:
        """Return b_T_a of this pose a_T_b."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return Pose2(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, wrap(-self.theta))

    def relative_to(self, other: Pose2) -> Pose2:
        """Return this pose in the frame of `other`."""
        return other.inverse().compose(self)

    def apply(self, points: FloatArray) -> FloatArray:
        """Transform points from the pose's own frame into the frame in which the pose is given.

        Args:
            points: (n, 2) in the pose's own frame, such as that of the base, in [m].

        Returns:
            (n, 2) in [m].
        """
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        rotation = np.array([[cos, sin], [-sin, cos]])
        moved: FloatArray = points @ rotation + np.array([self.x, self.y])
        return moved

    def distance(self, other: Pose2) -> float:
        """Return the straight distance, in [m], between the positions of this pose and of `other`."""
        return math.hypot(self.x - other.x, self.y - other.y)

    def turn(self, other: Pose2) -> float:
        """Return the size of the turn between this pose's heading and that of `other`, in [rad], 0 to pi."""
        return abs(wrap(self.theta - other.theta))

    def lift(self, z: float = 0.0) -> FloatArray:
        """Return this pose as a pose in space, a matrix (4, 4), at height `z` in [m] and without tilt."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return np.array(
            [[cos, -sin, 0.0, self.x], [sin, cos, 0.0, self.y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]
        )
