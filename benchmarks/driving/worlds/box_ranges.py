"""Exact ranges to boxes on the floor, as a perfect lidar would read them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray


def box_ranges(
    boxes: Iterable[tuple[float, float, float, float, float]], sensor: Pose2, angles: FloatArray
) -> FloatArray:
    """Return the range (n,) in [m] of each beam to the first box's side; inf if it meets no box.

    Args:
        boxes: (x, y, yaw, length, width) each, in [m] and [rad]; the sensor is outside of them.
        sensor: map_T_sensor.
        angles: (n,) angles of the beams in the sensor frame, in [rad].
    """
    nearest = np.full(len(angles), np.inf)
    for x, y, yaw, length, width in boxes:
        local = sensor.relative_to(Pose2(x, y, yaw))
        direction = np.column_stack([np.cos(angles + local.theta), np.sin(angles + local.theta)])
        direction = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
        half = np.array([length, width]) / 2.0
        here = np.array([local.x, local.y])
        one, other = (-half - here) / direction, (half - here) / direction
        enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
        hit = (enter < leave) & (enter > 0.0)
        nearest = np.where(hit, np.minimum(nearest, enter), nearest)
    return nearest
