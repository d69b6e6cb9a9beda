"""Price of straight lines over a grid of prices."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled


@compiled
def line_price(price: SingleArray, start: FloatArray, end: FloatArray, limit: float) -> float:
    """Return the price of a straight line, summed up from the cells' prices; infinity if it is above `limit`.

    The price is sampled once for each cell of length. The line is not checked for obstacles.

    Args:
        price: (h, w) price of a line of one cell's length, at each cell.
        start: (2,) row and column, in [cells]; cell centres are at whole numbers.
        end: (2,) row and column, in [cells].
        limit: price above which infinity is returned.
    """
    rows, columns = end[0] - start[0], end[1] - start[1]
    length = math.sqrt(rows * rows + columns * columns)
    count = int(length) + 1
    total = 0.0
    for i in range(count):
        row = int(start[0] + rows * (i + 0.5) / count + 0.5)
        column = int(start[1] + columns * (i + 0.5) / count + 0.5)
        total += float(price[row, column]) * length / count
        if total > limit:
            return np.inf
    return total
