"""Ground that earlier scans saw free: an obstacle there now has come since."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

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
    _clear: dict[float, FloatArray] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def spacing(self) -> float:
        """Angle between neighbouring beams, in [rad]."""
        return float((self.angles[-1] - self.angles[0]) / (len(self.angles) - 1))

    @cached_property
    def goes_round(self) -> bool:
        """True if the beams cover a full turn, so that the first beam is the last one's neighbour."""
        return len(self.angles) * self.spacing > 2.0 * np.pi - 1.5 * self.spacing

    def clear(self, reach: float) -> FloatArray:
        """Return how far, (n,) in [m], the ground is free along each beam and its neighbours on both sides.

        Args:
            reach: distance in [m] up to which a beam without an echo counts as free.
        """
        if reach not in self._clear:
            known = np.isfinite(self.ranges) | np.isposinf(self.ranges)
            lengths = np.where(known, np.minimum(self.ranges, reach), 0.0)
            border = {"mode": "wrap"} if self.goes_round else {"mode": "constant", "constant_values": 0.0}
            padded = np.pad(lengths, BEAMS_BESIDE, **border)
            self._clear[reach] = sliding_window_view(padded, 2 * BEAMS_BESIDE + 1).min(axis=1)
        return self._clear[reach]


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
    turned = np.arctan2(rays[:, 1], rays[:, 0]) - past.map_T_sensor.theta - past.angles[0]
    beam = np.round(np.mod(turned, 2.0 * np.pi) / past.spacing).astype(np.int64)
    clear = past.clear(reach)
    if past.goes_round:
        beam %= len(clear)
    inside = beam < len(clear)
    passed = np.where(inside, clear[np.where(inside, beam, 0)], 0.0)
    return np.asarray(passed > np.hypot(rays[:, 0], rays[:, 1]) + FREE_MARGIN_M)
