"""Speed limits by the room beside a footprint: slower between near obstacles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray, SingleArray

from .grid_map import GridMap
from .speed_limits import AllowedSpeeds

TIGHT_SPEED_M_S = 0.5  # where the footprint has no room beside it
SPEED_PER_ROOM = 5.0  # [1/s]: metres per second more for each metre of room
MIN_SPEED_M_S = 0.3


class RoomSpeeds(NamedTuple):
    """Speed limits that grow with the distance between the robot's outline and the nearest obstacle on a map.

    At places where another source of limits, `other`, allows less, that lower limit applies.
    """

    grid: GridMap
    clearance: SingleArray
    """(h, w) distance from the centres of the map's cells to the nearest obstacle, in [m]."""
    radius: float
    """Radius of the footprint, in [m]."""
    other: AllowedSpeeds | None = None

    def at(self, points: FloatArray, top: float) -> FloatArray:
        """Return the speed limits (n,) at points on a map, in [m/s], lower where obstacles are near.

        Args:
            points: (n, 2) on the map, in [m].
            top: top speed of the robot, in [m/s].
        """
        cells = np.clip(self.grid.to_cell(points), 0, np.array(self.clearance.shape) - 1)
        room = self.clearance[cells[:, 0], cells[:, 1]].astype(np.float64) - self.radius
        limits = np.clip(TIGHT_SPEED_M_S + SPEED_PER_ROOM * room, min(MIN_SPEED_M_S, top), top)
        return limits if self.other is None else np.minimum(limits, self.other.at(points, top))
