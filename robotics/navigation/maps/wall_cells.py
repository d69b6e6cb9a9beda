"""Occupied cells on the border of what a map shows, near a position."""

from __future__ import annotations

import math

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

from .grid_map import GridMap


class WallCells:
    """Wall cells of a map, occupied cells that have a free or unknown cell among their eight neighbours."""

    def __init__(self, grid: GridMap) -> None:
        """Prepare the occupied cells of a map."""
        solid = np.pad(grid.occupied.astype(np.uint8), 1, constant_values=0)
        inner = cv2.erode(solid, np.ones((3, 3), np.uint8))[1:-1, 1:-1]
        self._border = grid.occupied & (inner == 0)
        self._grid = grid

    def near(self, point: tuple[float, float], reach: float) -> FloatArray:
        """Return the centres (n, 2) of the wall cells around a point, on the map, in [m].

        Args:
            point: x and y on the map, in [m].
            reach: half side of the square around the point, in [m].
        """
        row, column = self._grid.to_cell(np.array([point]))[0].tolist()
        cells = math.ceil(reach / self._grid.resolution) + 1
        low = max(0, row - cells), max(0, column - cells)
        part = self._border[low[0] : max(0, row + cells + 1), low[1] : max(0, column + cells + 1)]
        return self._grid.to_point(np.argwhere(part) + low)

    def corners(self, centres: FloatArray, heading: float) -> FloatArray:
        """Return the centre and the four corners of each given cell, (5 n, 2) in the frame of `centres`, in
        [m].

        Args:
            centres: (n, 2) centres of cells, in a frame that may be turned relative to the map, in [m].
            heading: direction of that frame's x axis on the map, in [rad].
        """
        half = 0.5 * self._grid.resolution
        across = half * np.array([math.cos(heading), -math.sin(heading)])
        up = half * np.array([math.sin(heading), math.cos(heading)])
        offsets = np.array([0.0 * up, up + across, up - across, -up + across, -up - across])
        return np.asarray((centres[:, None] + offsets[None]).reshape(-1, 2))
