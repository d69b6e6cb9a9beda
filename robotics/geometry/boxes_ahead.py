"""Length of straight lines until they meet a box."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled

_STEEP = 1e-300  # minimum slope, for rays that are parallel to a side


@compiled
def boxes_ahead(
    start: FloatArray, ways: FloatArray, middles: FloatArray, turns: FloatArray, halves: FloatArray
) -> FloatArray:
    """Return the fraction of each straight line at which it first meets a box.

    Computed with the slab method of Kay and Kajiya, "Ray tracing complex scenes" (1986). A line that starts
    inside a box meets the box where it leaves it.

    Args:
        start: (3,) start of all lines, in any one frame, in [m].
        ways: (n, 3) vectors from the start to the ends of the lines, in [m], in the frame of `start`.
        middles: (k, 3) middles of the boxes in the same frame, in [m].
        turns: (k, 3, 3) rotations of the boxes in the same frame.
        halves: (k, 3) halves of their sides, in [m].

    Returns:
        (n,) from 0 to 1, without unit; infinite for a line that meets no box.
    """
    found = np.full(len(ways), np.inf)
    for box in range(len(middles)):
        turn, half = turns[box], halves[box]
        here = (start - middles[box]) @ turn
        for way in range(len(ways)):
            enters, leaves = -np.inf, np.inf
            for axis in range(3):
                ahead = (
                    ways[way, 0] * turn[0, axis] + ways[way, 1] * turn[1, axis] + ways[way, 2] * turn[2, axis]
                )
                if ahead == 0.0:
                    ahead = _STEEP
                one, other = (-half[axis] - here[axis]) / ahead, (half[axis] - here[axis]) / ahead
                enters, leaves = max(enters, min(one, other)), min(leaves, max(one, other))
            if enters <= leaves and leaves >= 0.0:
                found[way] = min(found[way], enters if enters >= 0.0 else leaves)
    return np.where(found <= 1.0, found, np.inf)
