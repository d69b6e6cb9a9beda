"""Ground that earlier scans saw free: an obstacle there now has come since."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.numerics.compiled import compiled_for

FREE_MARGIN_M = 0.15  # by which a beam has to have passed a point
BEAMS_BESIDE = 1  # beams on each side that have to have passed it as well


@dataclass(frozen=True, eq=False)
class PastScan:
    """A past scan with its time and the lidar's pose on the map."""

    time: float
    """Time of the scan, in [s]."""
    map_T_sensor: Pose2
    angles: FloatArray
    """(n,) in [rad], ascending and evenly spaced, in the sensor frame."""
    ranges: FloatArray
    """(n,) in [m]; infinity without an echo, NaN where nothing is known."""

    @cached_property
    def spacing(self) -> float:
        """Angle between neighbouring beams, in [rad]."""
        return float((self.angles[-1] - self.angles[0]) / (len(self.angles) - 1))

    @cached_property
    def goes_round(self) -> bool:
        """True if the beams cover a full turn, so that the first beam is the last one's neighbour."""
        return len(self.angles) * self.spacing > 2.0 * np.pi - 1.5 * self.spacing


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
    x, y, heading = past.map_T_sensor
    first = heading + float(past.angles[0])
    return _seen_free(points, past.ranges, x, y, first, past.spacing, past.goes_round, reach)


@compiled_for("(f8[:,::1], f8[::1], f8, f8, f8, f8, b1, f8)")
def _seen_free(
    points: FloatArray,
    ranges: FloatArray,
    sensor_x: float,
    sensor_y: float,
    first: float,
    spacing: float,
    goes_round: bool,
    reach: float,
) -> BoolArray:
    """Return the mask of `seen_free`; `first` is the direction of the first beam on the map, in [rad]."""
    count = len(ranges)
    free = np.zeros(len(points), dtype=np.bool_)
    for i in range(len(points)):
        x, y = points[i, 0] - sensor_x, points[i, 1] - sensor_y
        beam = int(np.round(((math.atan2(y, x) - first) % (2.0 * math.pi)) / spacing))
        if not goes_round and beam >= count:
            continue
        passed = np.inf
        for other in range(beam - BEAMS_BESIDE, beam + BEAMS_BESIDE + 1):
            if goes_round or 0 <= other < count:
                length = ranges[other % count]
                passed = min(passed, 0.0 if not length > -np.inf else min(length, reach))
            else:
                passed = 0.0
        free[i] = passed > math.hypot(x, y) + FREE_MARGIN_M
    return free
