"""Solution of the linear equations of a Markov chain."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, eye_array

from handcart.robotics.numerics.arrays import FloatArray

from .chain_rows import ChainLinks

DENSE_MAX_ROWS = 100
"""Rows up to which a full matrix is faster than a sparse one."""


class LinearSolver:
    """Solver of (I - Q) x = b and of (I - Q)ᵀ x = b for an absorbing Markov chain.

    Q holds the transition probabilities among the chain's transient states.
    """

    def __init__(self, size: int, links: ChainLinks, circles: bool) -> None:
        """Factorize the matrix I - Q.

        Args:
            size: number of rows.
            links: the transitions.
            circles: whether rows may follow each other in circles; otherwise what follows a row has a smaller
                number.
        """
        follows = csc_array((links.p, (links.row, links.to)), shape=(size, size))
        self._inverse: FloatArray | None = None
        if size <= DENSE_MAX_ROWS:
            self._inverse = np.linalg.inv(np.eye(size) - follows.toarray())
            return
        from scipy.sparse.linalg import splu  # late: most networks are small

        # Triangular, with a diagonal of ones: neither reordering nor pivots, nothing fills in.
        order, threshold = ("COLAMD", 1.0) if circles else ("NATURAL", 0.0)
        whole = (eye_array(size) - follows).tocsc()
        self._factors = splu(whole, permc_spec=order, diag_pivot_thresh=threshold)

    def solve(self, right: FloatArray, transposed: bool = False) -> FloatArray:
        """Return the solution x of (I - Q) x = b, in the unit of the right-hand side b.

        Args:
            right: (n,) or (n, k) right-hand sides b.
            transposed: True to solve (I - Q)ᵀ x = b instead.

        Returns:
            The solution, with the shape of `right`.
        """
        solution: FloatArray
        if self._inverse is None:
            solution = self._factors.solve(right, "T" if transposed else "N")
        else:
            solution = (self._inverse.T if transposed else self._inverse) @ right
        return solution
