"""The narrowest spot of the widest way between two parts of a map."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import IntArray, SingleArray
from handcart.robotics.numerics.compiled import compiled


def narrowest_spot(
    clearance: SingleArray, start: tuple[int, int], goal: tuple[int, int]
) -> tuple[int, int] | None:
    """Return the cell (row, column) that is the narrowest place of the widest way between two cells.

    Of all ways, the widest is the one whose narrowest place has the most room. Cells are added in the order
    of their room until start and goal are connected, also over corners; the last cell is the result (Hu,
    1961).

    Args:
        clearance: (h, w) distance of each cell from obstacles, in any one unit; not above zero where nothing
            can pass.
        start: row and column.
        goal: row and column.

    Returns:
        Row and column; None if no way leads from start to goal.
    """
    flat = np.ascontiguousarray(clearance).ravel()
    order = np.argsort(-flat, kind="stable")[: int(np.count_nonzero(flat > 0.0))]
    width = clearance.shape[1]
    last = _connect(order, clearance.shape, start[0] * width + start[1], goal[0] * width + goal[1])
    return None if last < 0 else (last // width, last % width)


@compiled
def _root(parent: IntArray, cell: int) -> int:
    root = cell
    while parent[root] != root:
        parent[root] = parent[parent[root]]
        root = int(parent[root])
    return root


@compiled
def _connect(order: IntArray, shape: tuple[int, int], start: int, goal: int) -> int:
    """Return the cell that connects start and goal when cells are added in this order; -1 if none does."""
    height, width = shape
    parent = np.full(height * width, -1)
    for cell in order:
        parent[cell] = cell
        row, column = cell // width, cell % width
        for r in range(max(row - 1, 0), min(row + 2, height)):
            for c in range(max(column - 1, 0), min(column + 2, width)):
                if parent[r * width + c] >= 0:
                    parent[_root(parent, r * width + c)] = _root(parent, cell)
        if parent[start] >= 0 and parent[goal] >= 0 and _root(parent, start) == _root(parent, goal):
            return int(cell)
    return -1
