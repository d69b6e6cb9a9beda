"""Length of straight lines until they meet rough ground."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled


@compiled
def ground_ahead(
    start: FloatArray, ways: FloatArray, corner: FloatArray, cell: float, heights: FloatArray, top: float
) -> FloatArray:
    """Return the fraction of each straight line at which it first comes below the ground.

    The ground's height is interpolated bilinearly between grid points. It is read about every half cell along
    a line, and taken as linear between two readings.

    Args:
        start: (3,) start of all lines, in any one frame with z up, in [m].
        ways: (n, 3) vectors from the start to the ends of the lines, in [m], in the frame of `start`.
        corner: (2,) place of `heights[0, 0]` in the same frame, in [m].
        cell: distance between points whose heights are given, in [m].
        heights: (rows, columns) in [m]; rows along y, columns along x.
        top: largest of `heights`, in [m].

    Returns:
        (n,) from 0 to 1, without unit; infinite for a line that stays above the ground.
    """
    rows, columns = heights.shape
    sides = (cell * (columns - 1), cell * (rows - 1))
    found = np.full(len(ways), np.inf)
    for way in range(len(ways)):
        enters, leaves = 0.0, 1.0
        for axis in range(2):
            here, ahead = start[axis] - corner[axis], ways[way, axis]
            if ahead == 0.0:
                if here < 0.0 or here > sides[axis]:
                    leaves = -1.0
            else:
                one, other = -here / ahead, (sides[axis] - here) / ahead
                enters, leaves = max(enters, min(one, other)), min(leaves, max(one, other))
        over, rises = start[2] - top, ways[way, 2]
        if over > 0.0:
            enters = max(enters, -over / rises) if rises < 0.0 else 2.0
        if enters > leaves:
            continue
        long = math.hypot(ways[way, 0], ways[way, 1]) * (leaves - enters)
        steps = math.ceil(2.0 * long / cell) + 1
        step, before = (leaves - enters) / steps, 0.0
        for k in range(steps + 1):
            share = enters + k * step
            across = min(max((start[0] + share * ways[way, 0] - corner[0]) / cell, 0.0), columns - 1.0)
            along = min(max((start[1] + share * ways[way, 1] - corner[1]) / cell, 0.0), rows - 1.0)
            i, j = min(int(along), rows - 2), min(int(across), columns - 2)
            u, v = along - i, across - j
            near = heights[i, j] * (1.0 - v) + heights[i, j + 1] * v
            far = heights[i + 1, j] * (1.0 - v) + heights[i + 1, j + 1] * v
            above = start[2] + share * ways[way, 2] - near * (1.0 - u) - far * u
            if above <= 0.0:
                found[way] = share if k == 0 else share + step * above / (before - above)
                break
            before = above
    return found
