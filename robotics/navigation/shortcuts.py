"""Straightening a path without giving its clearance away."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotics.navigation.compiled import compiled
from robotics.navigation.line_of_sight import line_price


@compiled
def _jumps(count: int) -> NDArray[np.int64]:
    """How many samples a shortcut may leap over: each number at first, then every next a quarter larger."""
    jumps = [1]
    while jumps[-1] < count:
        jumps.append(max(jumps[-1] + 1, jumps[-1] * 5 // 4))
    return np.array(jumps)


@compiled
def shortcuts(
    price: NDArray[np.float32], free: NDArray[np.bool_], path: NDArray[np.float64], longest: int
) -> NDArray[np.int64]:
    """Which samples of a path to keep so that the chain of straight leaps between them is cheapest.

    Found by dynamic programming; a leap may only lead over free cells.

    Args:
        price: (h, w) of each cell of length.
        free: (h, w).
        path: (n, 2) positions in [cells], row and column.
        longest: samples in the longest leap.
    """
    count = len(path)
    cost = np.full(count, np.inf)
    cost[0] = 0.0
    back = np.zeros(count, dtype=np.int64)
    jumps = _jumps(min(count - 1, longest))
    for j in range(1, count):
        for jump in jumps:
            if jump > j:
                break
            i = j - jump
            line = line_price(price, free, path[i], path[j], cost[j] - cost[i])
            if jump == 1 and line == np.inf:
                line = price[int(path[j, 0] + 0.5), int(path[j, 1] + 0.5)] * np.hypot(
                    path[j, 0] - path[i, 0], path[j, 1] - path[i, 1]
                )
            if cost[i] + line < cost[j]:
                cost[j], back[j] = cost[i] + line, i
    kept = [count - 1]
    while kept[-1] > 0:
        kept.append(back[kept[-1]])
    return np.array(kept[::-1])


@compiled
def rounded(
    clearance: NDArray[np.float32], free: NDArray[np.bool_], path: NDArray[np.float64], rounds: int
) -> NDArray[np.float64]:
    """Round the corners of an evenly sampled path (n, 2) in [cells], ends kept.

    Each sample moves towards the middle of its neighbours, unless that leaves the free cells, or leads below
    the path's least clearance.
    """
    smooth = path.copy()
    tight = np.inf
    for point in path:
        tight = min(tight, float(clearance[int(point[0] + 0.5), int(point[1] + 0.5)]))
    for _ in range(rounds):
        for i in range(1, len(smooth) - 1):
            row = 0.5 * smooth[i, 0] + 0.25 * (smooth[i - 1, 0] + smooth[i + 1, 0])
            column = 0.5 * smooth[i, 1] + 0.25 * (smooth[i - 1, 1] + smooth[i + 1, 1])
            cell = int(row + 0.5), int(column + 0.5)
            before = clearance[int(smooth[i, 0] + 0.5), int(smooth[i, 1] + 0.5)]
            if free[cell] and (clearance[cell] >= before or clearance[cell] > tight):
                smooth[i, 0], smooth[i, 1] = row, column
    return smooth
