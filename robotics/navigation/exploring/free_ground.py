"""Ground that is free although no beam crosses its cells: below a robot, and between neighbouring beams."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

GAP_M = 0.1
"""Width of gaps between beams that count as free: beams a degree apart leave them 6 m away."""
NEIGHBOUR_KERNEL = np.ones((3, 3), np.uint8)


def with_driven(grid: GridMap, poses: Sequence[Pose2], radius: float) -> GridMap:
    """Return a copy of a map, with unknown cells set free within a radius of poses that a robot has driven
    through.

    Args:
        grid: the map.
        poses: map_T_base of the robot on its way.
        radius: distance from a pose within which cells are free, in [m].
    """
    driven = np.zeros(grid.occupied.shape, np.uint8)
    cells = grid.to_cell(np.array([pose[:2] for pose in poses]))
    size = max(0, int(radius / grid.resolution))
    for row, column in cells.tolist():
        cv2.circle(driven, (column, row), size, 1, cv2.FILLED)
    return grid._replace(unknown=grid.unknown & (driven == 0))


def with_gaps_closed(grid: GridMap) -> GridMap:
    """Return a copy of a map in which small unknown spots, surrounded by free cells, are set free.

    Small spots are narrower than `GAP_M`. Unknown spots next to occupied cells stay unknown, because they may
    be inside a wall.
    """
    steps = math.ceil(0.5 * GAP_M / grid.resolution)
    open_ = (~grid.occupied).astype(np.uint8)
    grown = (~grid.blocked).astype(np.uint8)
    for _ in range(steps):
        grown = np.asarray(cv2.dilate(grown, NEIGHBOUR_KERNEL), dtype=np.uint8) & open_
    closed = cv2.erode(grown, NEIGHBOUR_KERNEL, iterations=steps)
    return grid._replace(unknown=grid.unknown & (closed == 0))
