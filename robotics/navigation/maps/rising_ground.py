"""Points of a level scan that may be rising ground instead of an obstacle."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

MAX_GROUND_SLOPE = 0.15  # [m/m] by which ground may rise from the base


def may_be_ground(points: FloatArray, height: float, tilt: tuple[float, float]) -> BoolArray:
    """Return a mask (n,), True for points of a scan that may be on the ground instead of on an obstacle.

    On a tilted base, beams of the lidar meet the ground, and ground may also rise. A point may be on the
    ground if its height, over the distance from the base, is at most the slope `MAX_GROUND_SLOPE`.

    Args:
        points: (n, 2) in the base frame, in [m].
        height: height of the sensor above the ground under the base, in [m].
        tilt: roll and pitch of the base, in [rad].
    """
    roll, pitch = tilt
    ahead, left = points.T
    lies = height - math.sin(pitch) * ahead + math.cos(pitch) * math.sin(roll) * left
    return np.asarray(lies <= MAX_GROUND_SLOPE * np.hypot(ahead, left))
