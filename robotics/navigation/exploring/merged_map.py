"""One map of two in the same frame."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray, IntArray


def merge_maps(drawn: GridMap, other: GridMap) -> GridMap:
    """Return a map with the cells of `drawn`, and with those of `other` where `drawn` is unknown or ends.

    Args:
        drawn: map whose cells are kept, and whose resolution is used.
        other: map of the same frame, with cells of any size.
    """
    low, high = _corners(drawn)
    other_low, other_high = _corners(other)
    before = np.maximum(0, np.ceil((low - other_low) / drawn.resolution - 1e-6)).astype(np.int64)
    after = np.maximum(0, np.ceil((other_high - high) / drawn.resolution - 1e-6)).astype(np.int64)
    canvas = _padded(drawn, before, after)
    cells = np.argwhere(canvas.unknown)
    points = canvas.to_point(cells)
    inside = other.inside(points)
    rows, columns = other.to_cell(points[inside]).T
    at = cells[inside]
    canvas.occupied[at[:, 0], at[:, 1]] = other.occupied[rows, columns]
    canvas.unknown[at[:, 0], at[:, 1]] = other.unknown[rows, columns]
    return canvas


def _corners(grid: GridMap) -> tuple[FloatArray, FloatArray]:
    """Return the lower-left and the upper-right corner (2,) of a map, in [m]."""
    low = np.array([grid.origin_x, grid.origin_y])
    return low, low + np.array(grid.occupied.shape[::-1]) * grid.resolution


def _padded(grid: GridMap, before: IntArray, after: IntArray) -> GridMap:
    """Return a copy of a map with unknown cells around it: so many (x, y) before and after it."""
    width = ((int(before[1]), int(after[1])), (int(before[0]), int(after[0])))
    x, y = grid.origin_x - before[0] * grid.resolution, grid.origin_y - before[1] * grid.resolution
    occupied = np.pad(grid.occupied, width)
    unknown = np.pad(grid.unknown, width, constant_values=True)
    return GridMap(occupied, unknown, grid.resolution, float(x), float(y))
