"""Any-angle shortest paths on a grid: Theta* (Nash et al., 2007), then pulled tight."""

from __future__ import annotations

import heapq
import math

import numpy as np

from handcart.robotics.navigation.maps.blocked_squares import BlockedSquares, blocked_squares, is_clear
from handcart.robotics.numerics.arrays import BoolArray, IntArray
from handcart.robotics.numerics.compiled import compiled


@compiled
def _sees(squares: BlockedSquares, need: float, row: int, column: int, to_row: int, to_column: int) -> bool:
    return is_clear(
        squares, np.array([float(row), float(column)]), np.array([float(to_row), float(to_column)]), need
    )


@compiled
def _theta_star(
    free: BoolArray,
    squares: BlockedSquares,
    need: float,
    start: IntArray,
    goal: IntArray,
) -> IntArray:
    """Return the parent (h * w,) of each cell, both as row * width + column; -1 for cells not reached."""
    height, width = free.shape
    cost = np.full(height * width, np.inf)
    parent = np.full(height * width, -1, dtype=np.int64)
    closed = np.zeros(height * width, dtype=np.bool_)
    first, last = start[0] * width + start[1], goal[0] * width + goal[1]
    cost[first], parent[first] = 0.0, first
    queue = [(0.0, np.int64(first))]
    while queue:
        cell = heapq.heappop(queue)[1]
        if cell == last:
            break
        if closed[cell]:
            continue
        closed[cell] = True
        row, column = cell // width, cell % width
        for turn in range(9):
            next_row, next_column = row + turn // 3 - 1, column + turn % 3 - 1
            if not (0 <= next_row < height and 0 <= next_column < width and free[next_row, next_column]):
                continue
            neighbour = next_row * width + next_column
            if closed[neighbour]:
                continue
            via = parent[cell]
            if not _sees(squares, need, via // width, via % width, next_row, next_column):
                via = cell
                if not _sees(squares, need, row, column, next_row, next_column):
                    continue
            new = cost[via] + math.hypot(next_row - via // width, next_column - via % width)
            if new < cost[neighbour] - 1e-9:
                cost[neighbour], parent[neighbour] = new, via
                rest = math.hypot(next_row - goal[0], next_column - goal[1])
                heapq.heappush(queue, (new + rest, np.int64(neighbour)))
    return parent


def shortest_path(free: BoolArray, start: IntArray, goal: IntArray) -> IntArray | None:
    """Return the corners (k, 2) of a nearly shortest path between two cells, or None if none exists.

    Each corner is the row and column of a cell. The robot counts as a point: the path stays within
    free cells, but may touch their border or corners.

    Args:
        free: (h, w) cells that the path may use.
        start: (2,) row and column, free.
        goal: (2,) row and column, free.
    """
    return shortest_clear_path(free, blocked_squares(~free), 0.0, start, goal)


def shortest_clear_path(
    free: BoolArray,
    squares: BlockedSquares,
    need: float,
    start: IntArray,
    goal: IntArray,
) -> IntArray | None:
    """Return the corners (k, 2) of a nearly shortest path for a robot that has a size, or None if none
    exists.

    Each corner is the row and column of a cell.

    Args:
        free: (h, w) cells at whose centres the path may bend.
        squares: blocked squares of the map.
        need: least distance of the path from blocked squares, in [cells].
        start: (2,) row and column, free.
        goal: (2,) row and column, free.
    """
    width = free.shape[1]
    parent = _theta_star(free, squares, need, np.asarray(start), np.asarray(goal))
    cell = int(goal[0]) * width + int(goal[1])
    if parent[cell] < 0:
        return None
    corners = [cell]
    while parent[cell] != cell:
        cell = int(parent[cell])
        corners.append(cell)
    return _pull_tight(squares, need, np.column_stack(np.divmod(np.array(corners[::-1]), width)))


def _pull_tight(squares: BlockedSquares, need: float, corners: IntArray) -> IntArray:
    """Leave out corners (k, 2) as long as their neighbours see each other."""
    kept = corners.tolist()
    i = 1
    while i < len(kept) - 1:
        if _sees(squares, need, *kept[i - 1], *kept[i + 1]):
            del kept[i]
            i = max(1, i - 1)
        else:
            i += 1
    return np.array(kept, dtype=np.int64)
