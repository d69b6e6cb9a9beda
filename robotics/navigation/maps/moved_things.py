"""Things that were measured elsewhere than a map shows them: their cells are drawn where they are now."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .grid_map import GridMap


class MovedThing(NamedTuple):
    """Outlines of a thing where it was when the map was made, and where it was measured later."""

    before: FloatArray
    """(n, 2) corners of a convex polygon on the map, counter-clockwise, in [m]."""
    now: FloatArray
    """(n, 2) corners of the same polygon where it was measured, counter-clockwise, in [m]."""


def with_moved(grid: GridMap, things: Iterable[MovedThing]) -> GridMap:
    """Return a map on which things are where they were measured.

    Cells within one cell of a thing's old outline become free, also those of other things there, such as a
    wall behind it, which has to be sensed again. Cells whose centre is within the new outline become
    occupied.
    """
    moved = list(things)
    if not moved:
        return grid
    occupied, unknown = grid.occupied.copy(), grid.unknown.copy()
    for thing in moved:
        _draw(grid, thing.before, grid.resolution, occupied, False)
        _draw(grid, thing.before, grid.resolution, unknown, False)
    for thing in moved:
        _draw(grid, thing.now, 0.0, occupied, True)
    return grid._replace(occupied=occupied, unknown=unknown & ~occupied)


def beside(points: FloatArray, outline: FloatArray, margin: float) -> BoolArray:
    """Return a mask (k,), True for points within a convex polygon, or at most a margin outside its sides.

    Args:
        points: (k, 2) in any one frame, in [m].
        outline: (n, 2) corners in the same frame, counter-clockwise, in [m].
        margin: distance from the lines through the sides, in [m].
    """
    sides = np.roll(outline, -1, axis=0) - outline
    outwards = np.column_stack([sides[:, 1], -sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    away = np.einsum("kij,ij->ki", points[:, None] - outline[None], outwards)
    return np.asarray((away <= margin).all(axis=1))


def _draw(grid: GridMap, outline: FloatArray, margin: float, cells: BoolArray, value: bool) -> None:
    """Set the cells (h, w) whose centres are within a margin of an outline."""
    low, high = grid.to_cell(np.array([outline.min(axis=0) - margin, outline.max(axis=0) + margin]))
    top, left = np.maximum(low, 0).tolist()
    bottom, right = np.minimum(high + 1, cells.shape).tolist()
    if top >= bottom or left >= right:
        return
    rows, columns = np.indices((bottom - top, right - left))
    window = np.column_stack([top + rows.ravel(), left + columns.ravel()])
    inside = window[beside(grid.to_point(window), outline, margin)]
    cells[inside[:, 0], inside[:, 1]] = value
