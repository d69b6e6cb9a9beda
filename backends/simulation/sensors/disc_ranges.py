"""Ranges of a perfect lidar to upright discs."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray


def cast_at_discs(discs: FloatArray, sensor: Pose2, angles: FloatArray, reach: float) -> FloatArray:
    """Return the range (n,) in [m] of each beam to the first disc; infinity beyond `reach`.

    A disc that contains the sensor is not seen.

    Args:
        discs: (k, 3) x and y in the world and radius, in [m].
        sensor: world_T_sensor.
        angles: (n,) of the beams in the sensor frame, in [rad], counter-clockwise from its x axis.
        reach: maximum range, in [m].
    """
    if not len(discs):
        return np.full(len(angles), np.inf)
    rays = discs[:, :2] - (sensor.x, sensor.y)
    beams = angles + sensor.theta
    along = rays[:, :1] * np.cos(beams) + rays[:, 1:] * np.sin(beams)
    across = rays[:, 1:] * np.cos(beams) - rays[:, :1] * np.sin(beams)
    inside = discs[:, 2:] ** 2 - across**2
    ranges = along - np.sqrt(np.maximum(inside, 0.0))
    ranges[(inside < 0.0) | (ranges <= 0.0) | (ranges > reach)] = np.inf
    return np.asarray(ranges.min(axis=0))
