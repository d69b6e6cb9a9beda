"""Speed limits by position: nav2's speed filter."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray, Int8Array


class AllowedSpeeds(Protocol):
    """Interface of speed limits that depend on the position on the map."""

    def at(self, points: FloatArray, top: float) -> FloatArray:
        """Return the speed limits (n,) at points, in [m/s].

        Args:
            points: (n, 2) on the map, in [m].
            top: top speed of the robot, in [m/s].
        """
        ...


class SpeedLimits(NamedTuple):
    """Speed limits from a mask over the map; at each cell the limit is `base` + `multiplier` * its value.

    The rules are those of nav2_costmap_2d/plugins/costmap_filters/speed_filter.cpp. There is no limit at
    cells that are 0 or unknown, beyond the mask, and where the limit is not above 0 or is above 100 percent.
    """

    values: Int8Array
    """(h, w) 0 to 100, -1 for unknown, row 0 at the bottom."""
    resolution: float
    """Side of a cell, in [m]."""
    origin: tuple[float, float]
    """Lower-left corner, in [m]."""
    percent: bool
    """True if limits are in percent of the top speed, False if in [m/s]."""
    base: float
    multiplier: float

    def at(self, points: FloatArray, top: float) -> FloatArray:
        """Return the speed limits (n,) at points, in [m/s].

        Args:
            points: (n, 2) on the map, in [m].
            top: top speed of the robot, in [m/s].
        """
        nothing = np.zeros(self.values.shape, dtype=np.bool_)
        grid = GridMap(nothing, nothing, self.resolution, *self.origin)
        cells, inside = grid.to_cell(points), grid.inside(points)
        values = np.zeros(len(cells))
        values[inside] = self.values[cells[inside, 0], cells[inside, 1]]
        limits = self.base + self.multiplier * values
        most = 100.0 if self.percent else np.inf
        holds = (values > 0) & (limits > 0.0) & (limits <= most)
        allowed = limits / 100.0 * top if self.percent else limits
        return np.where(holds, np.minimum(allowed, top), top)
