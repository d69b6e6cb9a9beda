"""Distance of one block from its goal."""

from __future__ import annotations

import math
from typing import NamedTuple


class BlockError(NamedTuple):
    """Error of one block in its goal's frame, goal minus actual, in [mm] (Hatano et al. 2000, eq. 14)."""

    number: int
    x: float
    y: float
    z: float
    turn_mrad: float
    processed_x: float
    """Error along x without the effects of the base's turn and tilt since the fixation (eq. 12)."""
    processed_y: float
    read_x: float
    """Error along x as read on the paper's scale with steps of 0.5 mm."""
    read_y: float
    yaw_mrad: float
    """Turn of the base from the fixation to the release of the block, positive to the left."""
    lean_mrad: float
    """Tilt of the base about its x axis from the fixation to the release of the block (the paper's pitch)."""

    @property
    def size(self) -> float:
        """Horizontal distance of the block from its goal, in [mm]."""
        return math.hypot(self.x, self.y)

    @property
    def processed(self) -> float:
        """Larger absolute error along x or y, in [mm], without the effects of the base's turn and tilt.

        Turn and tilt are those since the base was located by a landmark (Hatano et al. 2000, eq. 12).
        """
        return max(abs(self.processed_x), abs(self.processed_y))
