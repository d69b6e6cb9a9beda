"""Straight lines over a grid of clearances."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robotics.navigation.compiled import compiled


@compiled
def line_price(
    price: NDArray[np.float32],
    free: NDArray[np.bool_],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    limit: float,
) -> float:
    """Price of a straight line between two positions in [cells]; inf if it leaves `free` or is above `limit`.

    Read once a cell; positions are row and column, cell centres at whole numbers.
    """
    rows, columns = end[0] - start[0], end[1] - start[1]
    length = math.sqrt(rows * rows + columns * columns)
    count = int(length) + 1
    total = 0.0
    for i in range(count):
        row = int(start[0] + rows * (i + 0.5) / count + 0.5)
        column = int(start[1] + columns * (i + 0.5) / count + 0.5)
        if not free[row, column]:
            return np.inf
        total += float(price[row, column]) * length / count
        if total > limit:
            return np.inf
    return total


@compiled
def sees(free: NDArray[np.bool_], row: int, column: int, to_row: int, to_column: int) -> bool:
    """Whether the line between two cells stays on free cells."""
    rows, columns = to_row - row, to_column - column
    count = int(2.0 * math.sqrt(rows * rows + columns * columns)) + 1
    for i in range(count + 1):
        if not free[int(row + rows * i / count + 0.5), int(column + columns * i / count + 0.5)]:
            return False
    return True
