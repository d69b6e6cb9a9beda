"""Exact distances to blocked cells, each taken as a complete square.

A cell that is drawn as blocked has an obstacle somewhere in it, so only distances to its square hold for
cells of any size: measured to the centre, a wall on cells of 0.2 m may be 0.14 m nearer than it seems.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import (
    BoolArray,
    FloatArray,
    Int16Array,
    Int32Array,
    IntArray,
    SingleArray,
)
from handcart.robotics.numerics.compiled import compiled

# [cells], far above that of 32-bit distances: cells nearer to a limit are computed again
ROUNDING_CELLS = 1e-4
TOUCHING_CELLS = 1e-6  # [cells]: nearer than this, a line touches a square


class BlockedSquares(NamedTuple):
    """Tables of a map's blocked cells, for fast distance queries; everything beyond the map is blocked.

    The tables hold the nearest blocked row in each direction of a column, and the distance to the nearest
    blocked cell. The arrays `above`, `below` and `distance` are one cell larger than the map on every side.
    """

    above: Int16Array | Int32Array
    """(h + 2, w + 2) greatest row up to a cell's own that is blocked in its column, -1 if none is."""
    below: Int16Array | Int32Array
    """(h + 2, w + 2) least row from a cell's own on that is blocked in its column, h + 2 if none is."""
    distance: SingleArray
    """(h + 2, w + 2) from each cell's centre to the nearest blocked square, in [cells]."""


def blocked_squares(blocked: BoolArray) -> BlockedSquares:
    """Compute tables for fast distance queries from a mask (h, w) of a map's blocked cells."""
    padded = np.pad(blocked, 1, constant_values=True)
    whole = np.int16 if len(padded) < np.iinfo(np.int16).max else np.int32
    above, below = np.empty(padded.shape, dtype=whole), np.empty(padded.shape, dtype=whole)
    distance = np.empty(padded.shape, dtype=np.float32)
    _measure(padded, above, below, distance)
    return BlockedSquares(above, below, distance)


@compiled
def _measure(
    blocked: BoolArray,
    above: Int16Array,
    below: Int16Array,
    distance: SingleArray,
) -> None:
    """Fill in `above`, `below` and `distance`.

    Along each row, the lower envelope of parabolas (Felzenszwalb and Huttenlocher, 2012) is read half a cell
    to either side of a centre: the distance from there to a square's centre is that from the centre to the
    square's edge.
    """
    height, width = blocked.shape
    for column in range(width):
        above[0, column] = 0
        below[height - 1, column] = height - 1
    for row in range(1, height):
        for column in range(width):
            above[row, column] = row if blocked[row, column] else above[row - 1, column]
    for row in range(height - 2, -1, -1):
        for column in range(width):
            below[row, column] = row if blocked[row, column] else below[row + 1, column]
    upright = np.empty(width)
    apex, begin, between = np.empty(width, dtype=np.int64), np.empty(width + 1), np.empty(width)
    for row in range(height):
        for column in range(width):
            nearest = min(row - above[row, column], below[row, column] - row)
            upright[column] = (nearest - 0.5) ** 2 if nearest else 0.0
        _envelope(upright, apex, begin, between)
        distance[row, 0] = distance[row, width - 1] = 0.0
        for column in range(1, width - 1):
            beside = min(between[column - 1], between[column])
            distance[row, column] = math.sqrt(min(upright[column], beside))


@compiled
def _envelope(
    base: FloatArray,
    apex: IntArray,
    begin: FloatArray,
    between: FloatArray,
) -> None:
    """Compute the least (x - i)² + base[i] at each x = 0.5, 1.5, ... into `between`; `apex` and
    `begin` are scratch space.
    """
    last = 0
    apex[0], begin[0], begin[1] = 0, -np.inf, np.inf
    for i in range(1, len(base)):
        while True:
            other = apex[last]
            cross = (base[i] - base[other] + i * i - other * other) / (2.0 * (i - other))
            if cross > begin[last]:
                break
            last -= 1
        last += 1
        apex[last], begin[last], begin[last + 1] = i, cross, np.inf
    last = 0
    for i in range(len(base)):
        x = i + 0.5
        while begin[last + 1] < x:
            last += 1
        between[i] = (x - apex[last]) ** 2 + base[apex[last]]


@compiled
def _to_square(
    row0: float, column0: float, row1: float, column1: float, row: int, column: int, own: int, own_column: int
) -> float:
    """Squared distance of a stretch within the cell (own, own_column) to the square of another cell."""
    down = max(abs(row0 - row) - 0.5, 0.0)
    across = max(abs(column0 - column) - 0.5, 0.0)
    best = down * down + across * across
    down = max(abs(row1 - row) - 0.5, 0.0)
    across = max(abs(column1 - column) - 0.5, 0.0)
    best = min(best, down * down + across * across)
    if row == own or column == own_column:
        return best  # it grows evenly along the stretch
    corner = row + (0.5 if own > row else -0.5)
    corner_column = column + (0.5 if own_column > column else -0.5)
    rows, columns = row1 - row0, column1 - column0
    square = rows * rows + columns * columns
    if square > 0.0:
        at = ((corner - row0) * rows + (corner_column - column0) * columns) / square
        if 0.0 < at < 1.0:
            away = rows * (corner_column - column0) - columns * (corner - row0)
            best = min(best, away * away / square)
    return best


@compiled
def _stretch_clearance(
    squares: BlockedSquares,
    row0: float,
    column0: float,
    row1: float,
    column1: float,
    row: int,
    column: int,
    limit: float,
) -> float:
    """Return the least distance of a stretch within one cell to any blocked square, at most `limit`.

    It is -1 within a blocked square, 0 on its border.

    In each column only the nearest blocked cells on both sides can be the nearest, at each point of the
    stretch. All in [cells] of the padded map.
    """
    above, below = squares.above, squares.below
    height, width = above.shape
    if above[row, column] == row:
        inside = max(abs(0.5 * (row0 + row1) - row), abs(0.5 * (column0 + column1) - column)) < 0.5 - 1e-9
        return -1.0 if inside else min(limit, 0.0)
    if limit <= 0.0:
        return limit
    best = limit * limit
    low, high = min(column0, column1), max(column0, column1)
    top, bottom = min(row0, row1), max(row0, row1)
    for step in range(width):
        beyond = True
        for side in range(-1, 2, 2):
            other = column + side * step
            if other < 0 or other >= width or (step == 0 and side > 0):
                continue
            gap = (other - 0.5 - high) if side > 0 else (low - other - 0.5)
            if gap > 0.0 and gap * gap >= best:
                continue
            beyond = False
            left = best - max(gap, 0.0) ** 2
            up, down = int(above[row, other]), int(below[row, other])
            if up >= 0 and max(top - up - 0.5, 0.0) ** 2 < left:
                best = min(best, _to_square(row0, column0, row1, column1, up, other, row, column))
            if down < height and down != up and max(down - 0.5 - bottom, 0.0) ** 2 < left:
                best = min(best, _to_square(row0, column0, row1, column1, down, other, row, column))
        if beyond:
            break
    return math.sqrt(best)


@compiled
def line_clearance(
    squares: BlockedSquares, start: FloatArray, end: FloatArray, limit: float, enough: float
) -> float:
    """Return the least distance of a straight line to blocked squares, in [cells]; -1 if it crosses one.

    The line is followed from cell to cell (Amanatides and Woo, 1987). The distance is exact.

    Args:
        squares: blocked squares of the map.
        start: (2,) row and column on the map, in [cells], cell centres at whole numbers.
        end: (2,) row and column, in [cells].
        limit: largest result, in [cells]; greater clearances are not measured.
        enough: clearance below which -1 is returned as soon as that is sure, in [cells].
    """
    row0, column0, row1, column1 = start[0] + 1.0, start[1] + 1.0, end[0] + 1.0, end[1] + 1.0
    rows, columns = row1 - row0, column1 - column0
    row, column = math.floor(row0 + 0.5), math.floor(column0 + 0.5)
    last_row, last_column = math.floor(row1 + 0.5), math.floor(column1 + 0.5)
    down, right = 1 if rows > 0 else -1, 1 if columns > 0 else -1
    next_row = (row + 0.5 * down - row0) / rows if last_row != row else np.inf
    next_column = (column + 0.5 * right - column0) / columns if last_column != column else np.inf
    best, t = limit, 0.0
    begin, begin_column = row0, column0
    for left in range(abs(last_row - row) + abs(last_column - column), -1, -1):
        t = min(next_row, next_column) if left else 1.0
        finish, finish_column = row0 + t * rows, column0 + t * columns
        here = float(squares.distance[row, column])
        a = math.sqrt((begin - row) ** 2 + (begin_column - column) ** 2)
        b = math.sqrt((finish - row) ** 2 + (finish_column - column) ** 2)
        if here + min(a, b) + ROUNDING_CELLS < enough:
            return -1.0
        if here - max(a, b) - ROUNDING_CELLS < best:
            best = _stretch_clearance(squares, begin, begin_column, finish, finish_column, row, column, best)
            if best < enough:
                return -1.0
        if left:
            if next_row < next_column:
                row += down
                next_row = (row + 0.5 * down - row0) / rows if row != last_row else np.inf
            else:
                column += right
                next_column = (column + 0.5 * right - column0) / columns if column != last_column else np.inf
        begin, begin_column = finish, finish_column
    return best


@compiled
def is_clear(squares: BlockedSquares, start: FloatArray, end: FloatArray, need: float) -> bool:
    """Return True if a straight line keeps a clearance from every blocked square.

    Args:
        squares: blocked squares of the map.
        start: (2,) row and column, in [cells].
        end: (2,) row and column, in [cells].
        need: clearance in [cells]; with 0 the line may touch a square.
    """
    return line_clearance(squares, start, end, need, need) >= need


@compiled
def path_clearance(squares: BlockedSquares, path: FloatArray) -> FloatArray:
    """Return a lower bound of the distance to blocked squares along the segments that meet at each path
    point.

    At each place on these segments, the path is at least this far from blocked squares.

    Args:
        squares: blocked squares of the map.
        path: (n, 2) row and column, in [cells].

    Returns:
        (n,) in [cells].
    """
    height, width = squares.distance.shape
    clearance = np.full(len(path), np.inf)
    for i in range(max(len(path) - 1, 1)):
        j = min(i + 1, len(path) - 1)
        least = line_clearance(squares, path[i], path[j], float(height + width), 0.0)
        clearance[i] = min(clearance[i], least)
        clearance[j] = min(clearance[j], least)
    return clearance
