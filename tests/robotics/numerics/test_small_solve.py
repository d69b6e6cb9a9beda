"""Small linear systems in compiled code."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.robotics.numerics.small_solve import lapack_solved, solved


@given(st.integers(1, 6), st.integers(1, 13), st.integers(0, 10_000))
def test_solution_is_that_of_lapack(n: int, m: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix, right = rng.normal(size=(n, n)), rng.normal(size=(n, m))
    kept = matrix.copy(), right.copy()
    found = solved(matrix, right)
    tolerance = 1e-12 * np.linalg.cond(matrix)
    assert found == pytest.approx(np.linalg.solve(matrix, right), rel=tolerance, abs=tolerance)
    assert (matrix == kept[0]).all()
    assert (right == kept[1]).all()


def test_zero_on_the_diagonal_is_no_hindrance() -> None:
    found = solved(np.array([[0.0, 2.0], [1.0, 0.0]]), np.array([[4.0], [3.0]]))
    assert found.tolist() == [[3.0], [2.0]]


def test_lapack_solution_is_numpys_to_the_last_bit() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        half, right = rng.normal(size=(3, 3)), rng.normal(size=(3, 6))
        matrix = half @ half.T + 1e-6 * np.eye(3)
        found, wanted = lapack_solved(matrix, right), np.linalg.solve(matrix, right)
        assert found.tobytes() == wanted.tobytes()
        assert found.strides == wanted.strides
        assert lapack_solved(matrix, right[:, 0]).tobytes() == np.linalg.solve(matrix, right[:, 0]).tobytes()


def test_lapack_refuses_a_singular_matrix() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        lapack_solved(np.ones((3, 3)), np.ones(3))
