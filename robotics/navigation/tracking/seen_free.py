"""Ground that earlier scans saw free: an obstacle there now has come since."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

FREE_MARGIN_M = 0.15  # by which a beam has to have passed a point
BEAMS_BESIDE = 1  # beams on each side that have to have passed it as well


class PastScan(NamedTuple):
    """A past scan with its time and the pose of the lidar."""

    time: float
    """Time of the scan, in [s]."""
    map_T_sensor: Pose2
    angles: FloatArray
    """(n,) in [rad], ascending and evenly spaced, in the sensor frame."""
    ranges: FloatArray
    """(n,) in [m]; infinity without an echo, NaN where nothing is known."""


def seen_free(points: FloatArray, past: PastScan, reach: float) -> BoolArray:
    """Return a mask (k,), True for points that were free ground in an earlier scan.

    The beams on both sides of such a point ended at least `FREE_MARGIN_M` behind it.

    Args:
        points: (k, 2) on the map, in [m].
        past: the earlier scan.
        reach: distance in [m] up to which a beam without an echo counts as free.
    """
    if not len(points) or len(past.angles) < 2 * BEAMS_BESIDE + 2:
        return np.zeros(len(points), dtype=np.bool_)
    rays = points - np.array(past.map_T_sensor[:2])
    away = np.hypot(*rays.T)
    first, spacing = past.angles[0], (past.angles[-1] - past.angles[0]) / (len(past.angles) - 1)
    turned = np.arctan2(rays[:, 1], rays[:, 0]) - past.map_T_sensor.theta - first
    index = np.round(np.mod(turned, 2.0 * np.pi) / spacing).astype(np.int64)
    goes_round = len(past.angles) * spacing > 2.0 * np.pi - 1.5 * spacing
    known = np.isfinite(past.ranges) | np.isposinf(past.ranges)
    lengths = np.where(known, np.minimum(past.ranges, reach), 0.0)
    free = np.ones(len(points), dtype=np.bool_)
    for beside in range(-BEAMS_BESIDE, BEAMS_BESIDE + 1):
        beam = index + beside
        if goes_round:
            beam = np.mod(beam, len(lengths))
        inside = (beam >= 0) & (beam < len(lengths))
        free &= inside & (lengths[np.where(inside, beam, 0)] > away + FREE_MARGIN_M)
    return free
