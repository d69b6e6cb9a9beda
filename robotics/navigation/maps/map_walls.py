"""Obstacles of a map as rectangles, from which a world can be built."""

from __future__ import annotations

import math

import cv2
import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

THIN_WALL_CELLS = 0.1  # of a cell: thickness of a wall that is one cell wide
LONE_POST_CELLS = 0.5  # of a cell: side of a post of one cell

_RING = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], dtype=np.uint8)


def map_walls(grid: GridMap) -> FloatArray:
    """Return rectangles (n, 5) for the occupied cells: x, y, yaw, length and width on the map, in [m] and
    [rad].

    The rectangles end at the centres of the outermost occupied cells, where scan matching and planning assume
    surfaces. Rectangles of complete cells would be half a cell larger on every side. A line of cells one cell
    wide becomes a thin wall along the cells' centres. Occupied cells that touch, also at a corner only, are
    joined, so that neither a robot nor a beam passes between them.
    """
    cells = np.pad(grid.occupied, 1)
    a, b, c, d = cells[:-1, :-1], cells[:-1, 1:], cells[1:, :-1], cells[1:, 1:]
    filled = np.pad(a & b & c & d, 1)
    in_row = cells[:, :-1] & cells[:, 1:] & ~filled[:-1, 1:-1] & ~filled[1:, 1:-1]
    in_column = cells[:-1] & cells[1:] & ~filled[1:-1, :-1] & ~filled[1:-1, 1:]
    parts = [
        _blocks(filled[1:-1, 1:-1]),
        _lines(np.argwhere(in_row), (0, 1)),
        _lines(np.argwhere(in_column), (1, 0)),
        _lines(np.argwhere(a & d & ~b & ~c), (1, 1)),
        _lines(np.argwhere(np.pad(b & c & ~a & ~d, ((0, 0), (1, 0)))), (1, -1)),
        _posts(cells),
    ]
    table = np.vstack(parts)
    middles = grid.to_point(table[:, :2] - 1.0)
    return np.column_stack([middles, table[:, 2], table[:, 3:] * grid.resolution])


def _blocks(filled: BoolArray) -> FloatArray:
    """Return rectangles over squares between four occupied cells each: runs in rows, equal ones joined.

    Columns (n, 5) are row, column, yaw in [rad], length and width, in [cells].
    """
    squares = np.argwhere(filled)
    first, wide = _runs(squares[:, 0], squares[:, 1])
    row, column = squares[first].T
    first, high = _runs(column * (filled.shape[1] + 1) + wide, row)
    size = np.column_stack([high, wide[first]])
    middle = np.column_stack([row[first], column[first]]) + size / 2
    return np.column_stack([middle, np.zeros(len(first)), size[:, ::-1]])


def _lines(starts: IntArray, step: tuple[int, int]) -> FloatArray:
    """Return thin walls (k, 5) over joints (n, 2) from a cell to the one a step on, joined in rows."""
    down, right = step
    first, long = _runs(starts[:, 1] * down - starts[:, 0] * right, starts[:, 0 if down else 1])
    middle = starts[first] + long[:, None] * np.array(step) / 2
    yaw = np.full(len(first), math.atan2(down, right))
    return np.column_stack(
        [middle, yaw, long * math.hypot(*step) + THIN_WALL_CELLS, np.full(len(first), THIN_WALL_CELLS)]
    )


def _posts(cells: BoolArray) -> FloatArray:
    """Return small squares (k, 5) at the cells that touch no other."""
    lone = np.argwhere(cells & (cv2.dilate(cells.view(np.uint8), _RING) == 0))
    return np.column_stack([lone, np.zeros(len(lone)), np.full((len(lone), 2), LONE_POST_CELLS)])


def _runs(line: IntArray, at: IntArray) -> tuple[IntArray, IntArray]:
    """Return index of the first (k,) and length (k,) of unbroken runs of whole numbers `at` on one `line`."""
    order = np.lexsort((at, line))
    broken = (np.diff(line[order], prepend=-1) != 0) | (np.diff(at[order], prepend=-1) != 1)
    broken[:1] = True
    first = np.flatnonzero(broken)
    return order[first], np.diff(np.append(first, len(order)))
