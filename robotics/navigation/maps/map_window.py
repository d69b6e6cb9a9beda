"""Parts of a large map: a window about a place, and the complete map with larger cells."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray


def window_around(grid: GridMap, x: float, y: float, half: float) -> GridMap:
    """Return the cells of a map within a square, without copying them.

    Args:
        grid: the map.
        x: x of the square's centre on the map, in [m].
        y: y of the square's centre on the map, in [m].
        half: half of the square's side, in [m].
    """
    corners = grid.to_cell(np.array([[x - half, y - half], [x + half, y + half]]))
    low = np.clip(corners[0], 0, np.array(grid.occupied.shape) - 1)
    high = np.clip(corners[1] + 1, low + 1, grid.occupied.shape)
    rows, columns = slice(low[0], high[0]), slice(low[1], high[1])
    left, bottom = grid.origin_x + low[1] * grid.resolution, grid.origin_y + low[0] * grid.resolution
    movable = None if grid.movable is None else grid.movable[rows, columns]
    cells = grid.occupied[rows, columns], grid.unknown[rows, columns]
    return GridMap(*cells, grid.resolution, float(left), float(bottom), movable)


def coarsened(grid: GridMap, factor: int) -> GridMap:
    """Return a map with cells that are `factor` times as wide.

    A wide cell is occupied if any of the cells in it is occupied, and otherwise unknown if any of them is
    unknown.

    Cells beyond the map's upper and right border count as unknown.
    """
    occupied, unknown = _any_of(grid.occupied, factor, False), _any_of(grid.unknown, factor, True)
    movable = None if grid.movable is None else _any_of(grid.movable, factor, False)
    wide = grid.resolution * factor
    return GridMap(occupied, unknown & ~occupied, wide, grid.origin_x, grid.origin_y, movable)


def _any_of(cells: BoolArray, factor: int, beyond: bool) -> BoolArray:
    """Return (h, w) whether any cell of each block is True; cells off the map have the value `beyond`."""
    height, width = (-(-side // factor) for side in cells.shape)
    found = np.zeros((height, width), dtype=np.bool_)
    for i in range(factor):
        for j in range(factor):
            part = cells[i::factor, j::factor]
            found[: part.shape[0], : part.shape[1]] |= part
            if beyond:
                found[part.shape[0] :] = True
                found[:, part.shape[1] :] = True
    return found


def with_cells_at(grid: GridMap, points: FloatArray) -> GridMap:
    """Return a map on which the cells that contain points (n, 2) on the map, in [m], are occupied; others
    stay unchanged.
    """
    if not len(points):
        return grid
    rows, columns = grid.to_cell(points[grid.inside(points)]).T
    occupied, unknown = grid.occupied.copy(), grid.unknown.copy()
    occupied[rows, columns], unknown[rows, columns] = True, False
    return GridMap(occupied, unknown, *grid[2:])


def is_within(grid: GridMap, points: FloatArray, margin: float) -> BoolArray:
    """Return a mask (n,), True for points that are at least a margin inside the edge of a map.

    Args:
        grid: the map.
        points: (n, 2) in the map frame, in [m].
        margin: distance from the edge, in [m].
    """
    low = np.array([grid.origin_x, grid.origin_y])
    high = low + np.array(grid.occupied.shape[::-1]) * grid.resolution
    within: BoolArray = np.all((points >= low + margin) & (points <= high - margin), axis=1)
    return within
