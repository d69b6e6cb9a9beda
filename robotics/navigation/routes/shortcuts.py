"""Straightening a path without giving its clearance away."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.navigation.maps.blocked_squares import ROUNDING_CELLS, BlockedSquares, is_clear
from handcart.robotics.navigation.routes.line_price import line_price
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from handcart.robotics.numerics.compiled import compiled

SAMPLE_SPACING_CELLS = 4.0  # of the path, in [cells], before shortcuts
LONGEST_LEAP = 50  # samples


# Numbers are copied one by one here: numba takes two seconds to compile a copy of an array's row.


@compiled
def _apart(one: FloatArray, other: FloatArray) -> float:
    return math.sqrt((one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2)


def _jumps(count: int) -> IntArray:
    """Return the numbers of samples a shortcut may skip: one by one at first, then each a quarter larger."""
    jumps = [1]
    while jumps[-1] < count:
        jumps.append(max(jumps[-1] + 1, jumps[-1] * 5 // 4))
    return np.array(jumps)


def path_length(path: FloatArray) -> float:
    """Return the length of a path (n, 2) in any one frame, in the unit of its points."""
    return float(_length(_as_floats(path)))


def sampled(path: FloatArray, spacing: float) -> FloatArray:
    """Return a path with points inserted, so that neighbours are at most a spacing apart.

    Repeated points are removed.

    Args:
        path: (n, 2) in any one frame and unit.
        spacing: largest distance of neighbours, in the same unit.

    Returns:
        (m, 2) in the same frame and unit.
    """
    return _sampled(_as_floats(path), float(spacing))


def _as_floats(path: FloatArray) -> FloatArray:
    """Return the path as the one type of array that the compiled functions are compiled for."""
    return np.ascontiguousarray(path, dtype=np.float64)


@compiled
def _length(path: FloatArray) -> float:
    total = 0.0
    for i in range(len(path) - 1):
        total += _apart(path[i], path[i + 1])
    return total


@compiled
def _sampled(path: FloatArray, spacing: float) -> FloatArray:
    """Return the path (m, 2) with points inserted, as `sampled` does."""
    parts = np.empty(len(path), dtype=np.int64)
    count = 1
    for i in range(len(path) - 1):
        parts[i] = math.ceil(_apart(path[i], path[i + 1]) / spacing)
        count += parts[i]
    points = np.empty((count, 2))
    points[0, 0], points[0, 1] = path[0, 0], path[0, 1]
    at = 1
    for i in range(len(path) - 1):
        for number in range(1, parts[i] + 1):
            share = number / parts[i]
            for k in range(2):
                between = path[i, k] + share * (path[i + 1, k] - path[i, k])
                points[at, k] = path[i + 1, k] if number == parts[i] else between
            at += 1
    return points


@compiled
def _evenly(path: FloatArray, spacing: float) -> IntArray:
    """About every `spacing` one point of a path (n, 2), first and last included."""
    chosen = np.zeros(len(path), dtype=np.int64)
    count, along = 1, 0.0
    for i in range(1, len(path)):
        along += _apart(path[i - 1], path[i])
        if along >= spacing * (1.0 - 1e-9) or i == len(path) - 1:
            chosen[count], along = i, 0.0
            count += 1
    return chosen[:count]


def straightened(
    price: SingleArray, haste: float, squares: BlockedSquares, need: float, path: FloatArray
) -> FloatArray:
    """Return the corners (k, 2), row and column in [cells], of the cheapest chain of straight lines between
    samples of a path.

    The chain is found by dynamic programming. Each line keeps the clearance `need` from blocked squares.
    Where not even two successive samples can be joined by such a line, the path is followed from one to the
    other, point by point.

    Args:
        price: (h, w) price of a line of one cell's length, at each cell.
        haste: price that is added for each cell of length.
        squares: blocked squares of the map.
        need: clearance of every line, in [cells]; the path itself has it.
        path: (n, 2) row and column, in [cells].
    """
    path = sampled(path, SAMPLE_SPACING_CELLS)
    samples = _evenly(path, SAMPLE_SPACING_CELLS)
    jumps = _jumps(min(len(samples) - 1, LONGEST_LEAP))
    back, walked = _leaps(price, haste, squares, need, path, samples, jumps)
    kept = [samples[-1]]
    j = len(samples) - 1
    while j > 0:
        if walked[j]:
            kept.extend(range(samples[j] - 1, samples[j - 1], -1))
        j = back[j]
        kept.append(samples[j])
    return path[kept[::-1]]


@compiled
def _leaps(
    price: SingleArray,
    haste: float,
    squares: BlockedSquares,
    need: float,
    path: FloatArray,
    samples: IntArray,
    jumps: IntArray,
) -> tuple[IntArray, BoolArray]:
    """Return for each sample (s,) the index of its predecessor, and True where the path itself is
    followed.
    """
    count = len(samples)
    cost, back = np.empty(count), np.empty(count, dtype=np.int64)
    cost[0], back[0] = 0.0, -1
    walked = np.zeros(count, dtype=np.bool_)
    for j in range(1, count):
        end = path[samples[j]]
        walk = 0.0
        for k in range(samples[j - 1], samples[j]):
            step = haste * _apart(path[k], path[k + 1])
            walk += line_price(price, path[k], path[k + 1], np.inf) + step
        cost[j], back[j], walked[j] = cost[j - 1] + walk, j - 1, True
        for jump in jumps:
            if jump > j:
                break
            i = j - jump
            begin = path[samples[i]]
            so_far = cost[i] + haste * _apart(begin, end)
            line = line_price(price, begin, end, cost[j] - so_far)
            if so_far + line <= cost[j] and is_clear(squares, begin, end, need):
                cost[j], back[j], walked[j] = so_far + line, i, False
    return back, walked


@compiled
def around_corners(free: BoolArray, squares: BlockedSquares, need: float, way: IntArray) -> FloatArray:
    """Return a path (m, 2), row and column in [cells], in which diagonal steps that pass a blocked corner too
    closely are replaced.

    Each such step leads over a neighbouring free cell instead.

    Args:
        free: (h, w) cells whose centres have the clearance `need`.
        squares: blocked squares of the map.
        need: clearance that a step must have, in [cells].
        way: (n, 2) row and column of the path's cells; lines longer than one step have the clearance already.
    """
    path = np.empty((2 * len(way), 2))
    count = 0
    for i in range(len(way)):
        path[count, 0], path[count, 1] = way[i, 0], way[i, 1]
        count += 1
        if i + 1 == len(way) or abs(way[i, 0] - way[i + 1, 0]) != 1 or abs(way[i, 1] - way[i + 1, 1]) != 1:
            continue
        path[count, 0], path[count, 1] = way[i + 1, 0], way[i + 1, 1]
        if not is_clear(squares, path[count - 1], path[count], need):
            if free[way[i, 0], way[i + 1, 1]]:
                path[count, 0] = way[i, 0]
            else:
                path[count, 1] = way[i, 1]
            count += 1
    return path[:count]


@compiled
def rounded(squares: BlockedSquares, need: float, path: FloatArray, rounds: int, roomy: float) -> FloatArray:
    """Return an evenly sampled path (n, 2) with rounded corners and the same ends, row and column in [cells].

    Each sample moves towards the middle of its neighbours. It stays if the line to one of them would then
    have too little clearance: less than `need` or than the least clearance of the path.

    Args:
        squares: blocked squares of the map.
        need: clearance to keep, in [cells].
        path: (n, 2) row and column, evenly sampled, in [cells].
        rounds: number of passes over the samples.
        roomy: clearance, in [cells]; a sample with less clearance than this does not lose any by the
            rounding.
    """
    smooth = path.copy()
    tight = np.inf
    for point in path:
        tight = min(tight, float(squares.distance[int(point[0] + 1.5), int(point[1] + 1.5)]))
    least = max(need, tight - 0.71)  # half a cell's diagonal: the point isn't the centre of its cell
    moved = np.empty(2)
    for _ in range(rounds):
        for i in range(1, len(smooth) - 1):
            own = float(squares.distance[int(path[i, 0] + 1.5), int(path[i, 1] + 1.5)]) - 0.71
            keep = max(least, min(own, roomy))
            moved[0] = 0.5 * smooth[i, 0] + 0.25 * (smooth[i - 1, 0] + smooth[i + 1, 0])
            moved[1] = 0.5 * smooth[i, 1] + 0.25 * (smooth[i - 1, 1] + smooth[i + 1, 1])
            if abs(moved[0] - smooth[i, 0]) + abs(moved[1] - smooth[i, 1]) < 1e-6:
                continue
            row, column = int(moved[0] + 0.5), int(moved[1] + 0.5)
            far = max(_apart(moved, smooth[i - 1]), _apart(moved, smooth[i + 1]))
            off = math.sqrt((moved[0] - row) ** 2 + (moved[1] - column) ** 2)
            if squares.distance[row + 1, column + 1] > keep + far + off + ROUNDING_CELLS or (
                is_clear(squares, smooth[i - 1], moved, keep)
                and is_clear(squares, moved, smooth[i + 1], keep)
            ):
                smooth[i, 0], smooth[i, 1] = moved[0], moved[1]
    return smooth
