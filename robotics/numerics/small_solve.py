"""Solutions of small linear systems: in compiled code, and by LAPACK without NumPy's checks.

Numba takes seconds to compile a call of LAPACK. For three unknowns, NumPy's checks take five times as long
as LAPACK.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgesv

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled


@compiled
def solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solution x (n, m) of matrix x = right, by Gaussian elimination with row pivots.

    Args:
        matrix: (n, n) in any units.
        right: (n, m) in any units.

    Raises:
        ZeroDivisionError: the matrix is exactly singular.
    """
    left, out = matrix.copy(), right.copy()
    n, m = out.shape
    for column in range(n):
        pivot = column
        for row in range(column + 1, n):
            if abs(left[row, column]) > abs(left[pivot, column]):
                pivot = row
        for other in range(n):
            left[column, other], left[pivot, other] = left[pivot, other], left[column, other]
        for other in range(m):
            out[column, other], out[pivot, other] = out[pivot, other], out[column, other]
        for row in range(column + 1, n):
            factor = left[row, column] / left[column, column]
            for other in range(column, n):
                left[row, other] -= factor * left[column, other]
            for other in range(m):
                out[row, other] -= factor * out[column, other]
    for row in range(n - 1, -1, -1):
        for other in range(m):
            for later in range(row + 1, n):
                out[row, other] -= left[row, later] * out[later, other]
            out[row, other] /= left[row, row]
    return out


def lapack_solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solution x, (n,) or (n, m), of matrix x = right, identical to that of `numpy.linalg.solve`.

    Args:
        matrix: (n, n) in any units.
        right: (n,) or (n, m) in any units.

    Raises:
        numpy.linalg.LinAlgError: the matrix is exactly singular.
    """
    _, _, solution, info = dgesv(matrix, right)
    if info > 0:
        raise np.linalg.LinAlgError("Singular matrix")
    return np.ascontiguousarray(solution)  # in the order of NumPy: products depend on it to the last bit
