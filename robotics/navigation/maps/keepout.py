"""Zones that a robot keeps out of although they are free: nav2's keepout filter."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, IntArray


def with_keepout(grid: GridMap, zones: GridMap) -> GridMap:
    """Return a map on which the cells that a keepout zone touches are unknown.

    Routes avoid unknown cells, and scans are not matched with them as walls.

    Args:
        grid: the map.
        zones: map whose occupied cells are keepout zones; its cell size and origin may differ from those of
            `grid`.
    """
    barred = keepout_cells(grid, zones)
    return grid._replace(unknown=grid.unknown | (barred & ~grid.occupied))


def keepout_cells(grid: GridMap, zones: GridMap) -> BoolArray:
    """Return a mask (h, w), True for cells of `grid` that a keepout zone touches.

    A zone touches a cell if the cell's centre is in the zone, or if the cell contains the centre of a cell of
    the zone.

    Args:
        grid: map of whose cells the mask is made.
        zones: map in the same frame, whose occupied cells are the zones.
    """
    height, width = grid.occupied.shape
    across, up = np.arange(width, dtype=np.int64), np.arange(height, dtype=np.int64)
    columns = zones.to_cell(grid.to_point(np.column_stack([0 * across, across])))[:, 1]
    rows = zones.to_cell(grid.to_point(np.column_stack([up, 0 * up])))[:, 0]
    barred = _picked(zones.occupied, rows, columns)
    own = np.argwhere(zones.occupied)
    if len(own):
        points = zones.to_point(own)
        cells = grid.to_cell(points[grid.inside(points)])
        barred[cells[:, 0], cells[:, 1]] = True
    return barred


def _picked(cells: BoolArray, rows: IntArray, columns: IntArray) -> BoolArray:
    """Return the cells (len(rows), len(columns)) at some rows and columns, False beyond the edge."""
    height, width = cells.shape
    inside = ((rows >= 0) & (rows < height))[:, None] & ((columns >= 0) & (columns < width))
    picked = cells[np.clip(rows, 0, height - 1)[:, None], np.clip(columns, 0, width - 1)]
    found: BoolArray = picked & inside
    return found
