"""The inner loops of dividing a path, compiled.

Arrays are (p, b): points x placements. A step joins two neighbouring points; its gain is its length times
the mean of the scores at both ends, and a placement must be usable at both.
"""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from handcart.robotics.numerics.compiled import compiled, compiled_for


@compiled_for("(f4[:,::1], b1[:,::1], b1[:,::1], f8[::1], i8)")
def layers(
    values: SingleArray, usable: BoolArray, joined: BoolArray, steps: FloatArray, count: int
) -> IntArray:
    """Return the base pose (placement) for each step of a path, so that the integral of the score is
    greatest.

    The result (p-1,) holds column numbers of `values`. A step leads from a point of the path to the next, and
    is tracked from one placement. There has to be at least one solution with at most `count` placements in a
    row.

    Args:
        values: (p, b) scores of points from placements, from 0 to 1.
        usable: (p, b) True where a placement reaches a point.
        joined: (p-1, b) True where the arm does not jump in a step; empty: it jumps in none.
        steps: (p-1,) lengths of the steps, in [m].
        count: largest number of placements, one after the other.
    """
    points, bases = values.shape
    best = np.full((count, bases), -np.inf)
    stays = np.zeros((points - 1, count, bases), dtype=np.bool_)
    tops = np.full((points, count), -np.inf)
    holders = np.zeros((points, count), dtype=np.int64)
    for j in range(points - 1):
        half = 0.5 * steps[j]
        for k in range(count):
            entered = tops[j, k - 1] if k > 0 else (0.0 if j == 0 else -np.inf)
            top, holder = -np.inf, 0
            for b in range(bases):
                if not (usable[j, b] and usable[j + 1, b]) or (joined.size and not joined[j, b]):
                    best[k, b] = -np.inf
                    continue
                stay = best[k, b] >= entered
                stays[j, k, b] = stay
                value = (best[k, b] if stay else entered) + half * (values[j, b] + values[j + 1, b])
                best[k, b] = value
                if value > top:
                    top, holder = value, b
            tops[j + 1, k], holders[j + 1, k] = top, holder
    return _backwards(stays, tops, holders)


@compiled
def _backwards(stays: BoolArray, tops: FloatArray, holders: IntArray) -> IntArray:
    steps, count, _ = stays.shape
    k = 0
    for other in range(1, count):
        if tops[steps, other] > tops[steps, k]:
            k = other
    chosen = np.zeros(steps, dtype=np.int64)
    base = holders[steps, k]
    for j in range(steps - 1, -1, -1):
        chosen[j] = base
        if not stays[j, k, base] and j > 0:
            k -= 1
            base = holders[j, k]
    return chosen


@compiled
def cheapest_layers(
    values: SingleArray, usable: BoolArray, joined: BoolArray, steps: FloatArray, cost: float
) -> IntArray:
    """Return the base pose (placement) for each step of a path that gives the greatest value.

    The result (p-1,) holds column numbers of `values`.

    The value is the integral of the score along the path, less `cost` for each change of the base pose. A
    step leads from a point of the path to the next, and is tracked from one placement.

    Args:
        values: (p, b) scores of points from placements, from 0 to 1.
        usable: (p, b) True where a placement reaches a point.
        joined: (p-1, b) True where the arm does not jump in a step; empty: it jumps in none.
        steps: (p-1,) lengths of the steps, in [m].
        cost: price of a change of placement, in [m].
    """
    points, bases = values.shape
    best = np.full(bases, -np.inf)
    stays = np.zeros((points - 1, bases), dtype=np.bool_)
    holders = np.zeros(points, dtype=np.int64)
    entered = 0.0
    for j in range(points - 1):
        half = 0.5 * steps[j]
        top, holder = -np.inf, 0
        for b in range(bases):
            if not (usable[j, b] and usable[j + 1, b]) or (joined.size and not joined[j, b]):
                best[b] = -np.inf
                continue
            stay = best[b] >= entered
            stays[j, b] = stay
            value = (best[b] if stay else entered) + half * (values[j, b] + values[j + 1, b])
            best[b] = value
            if value > top:
                top, holder = value, b
        holders[j + 1] = holder
        entered = top - cost
    chosen = np.zeros(points - 1, dtype=np.int64)
    base = holders[points - 1]
    for j in range(points - 2, -1, -1):
        chosen[j] = base
        if not stays[j, base]:
            base = holders[j]
    return chosen


@compiled_for("(b1[:,::1], b1[:,::1], i8)")
def farthest_run(usable: BoolArray, joined: BoolArray, first: int) -> tuple[int, int]:
    """Return the placement (base pose) that tracks the longest part of a path that begins at the point
    `first`.

    The result is the column of this placement and the index of the last point of the part. If no placement
    reaches the point after `first`, the result is -1 and `first`.

    Args:
        usable: (p, b) True where a placement reaches a point.
        joined: (p-1, b) True where the arm does not jump in a step; empty: it jumps in none.
        first: index of the first point.
    """
    placement, farthest = -1, first
    for b in range(usable.shape[1]):
        last = run_end(usable, joined, first, b)
        if last > farthest:
            placement, farthest = b, last
    return placement, farthest


@compiled
def segment_score(values: SingleArray, steps: FloatArray, placement: int, first: int, last: int) -> float:
    """Return the integral, between two points of a path, of the scores that one base pose (its placement) has
    there, in [m].

    Args:
        values: (p, b) scores, from 0 to 1, of each point of the path from each placement.
        steps: (p-1,) distances of neighbouring points of the path, in [m].
        placement: column of the placement.
        first: index of the first point.
        last: index of the last point.
    """
    total = 0.0
    for j in range(first, last):
        total += 0.5 * steps[j] * (values[j, placement] + values[j + 1, placement])
    return total


@compiled
def run_end(usable: BoolArray, joined: BoolArray, first: int, placement: int) -> int:
    """Return the index of the last point up to which the arm can follow a path, from the point `first` on,
    without a gap or a jump.

    The base stays at one pose, its placement.

    Args:
        usable: (p, b) True where the arm reaches a point from a placement.
        joined: (p-1, b) True where the arm does not jump between a point and the next one; empty: it never
            jumps.
        first: index of the point to start from.
        placement: column of the placement.
    """
    if not usable[first, placement]:
        return first
    last = first
    while last + 1 < usable.shape[0] and usable[last + 1, placement]:
        if joined.size and not joined[last, placement]:
            break
        last += 1
    return last
