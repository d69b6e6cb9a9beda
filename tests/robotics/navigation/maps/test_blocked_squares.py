from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from benchmarks.driving.worlds.random_grids import distance_to_squares
from handcart.robotics.navigation.maps.blocked_squares import (
    TOUCHING_CELLS,
    blocked_squares,
    is_clear,
    line_clearance,
    path_clearance,
)

GRIDS = hnp.arrays(bool, st.tuples(st.integers(1, 8), st.integers(1, 8)))
FAR = 1e9


def share(numerator: int) -> float:
    return numerator / 16.0  # halves among them: rims and corners of squares are met exactly


SHARES = st.tuples(*[st.integers(0, 15).map(share)] * 4)


def ends(blocked: np.ndarray, shares: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    size = np.array(blocked.shape)
    return np.array(shares[:2]) * size - 0.5, np.array(shares[2:]) * size - 0.5


@settings(deadline=None, max_examples=80)
@given(GRIDS)
def test_distances_of_centres_are_exact(blocked: np.ndarray) -> None:
    cells = np.argwhere(np.ones_like(blocked)).astype(float)
    exact = distance_to_squares(blocked, cells).reshape(blocked.shape)
    assert np.allclose(blocked_squares(blocked).distance[1:-1, 1:-1], exact, atol=1e-6)


@pytest.mark.slow
@settings(deadline=None, max_examples=150)
@given(GRIDS, SHARES)
def test_line_clearance_is_the_least_distance_along_it(
    blocked: np.ndarray, shares: tuple[float, ...]
) -> None:
    start, end = ends(blocked, shares)
    clearance = line_clearance(blocked_squares(blocked), start, end, FAR, 0.0)
    line = start + np.linspace(0.0, 1.0, 300)[:, None] * (end - start)
    nearest = distance_to_squares(blocked, line).min()
    assert nearest >= clearance - 1e-9
    assert nearest <= max(clearance, 0.0) + np.hypot(*(end - start)) / 300


@settings(deadline=None, max_examples=100)
@given(GRIDS, SHARES, st.floats(TOUCHING_CELLS, 3.0))
def test_a_line_is_clear_exactly_when_its_clearance_suffices(
    blocked: np.ndarray, shares: tuple[float, ...], need: float
) -> None:
    squares, (start, end) = blocked_squares(blocked), ends(blocked, shares)
    clearance = line_clearance(squares, start, end, FAR, 0.0)
    if abs(clearance - need) > 1e-9:
        assert is_clear(squares, start, end, need) == (clearance > need)
        assert is_clear(squares, end, start, need) == is_clear(squares, start, end, need)


def test_no_room_between_blocked_cells_that_share_a_corner() -> None:
    squares = blocked_squares(np.array([[False, True], [True, False]]))
    line = np.array([0.0, 0.0]), np.array([1.0, 1.0])
    assert line_clearance(squares, *line, FAR, 0.0) == 0.0
    assert is_clear(squares, *line, 0.0)
    assert not is_clear(squares, *line, 1e-6)


def test_room_along_a_wall_reaches_its_face_not_cell_centres() -> None:
    blocked = np.zeros((5, 40), dtype=bool)
    blocked[4] = True
    squares = blocked_squares(blocked)
    assert line_clearance(squares, np.array([2.0, 3.0]), np.array([2.0, 35.0]), FAR, 0.0) == 1.5
    path = np.array([[2.0, 3.0], [2.0, 20.0], [1.0, 30.0]])
    assert path_clearance(squares, path).tolist() == pytest.approx([1.5, 1.5, 1.5])
    assert path_clearance(squares, path[::-1] - [0.25, 0.0]).tolist() == pytest.approx([1.25, 1.25, 1.75])


def test_line_through_a_thin_wall_is_blocked_at_any_angle() -> None:
    blocked = np.zeros((30, 30), dtype=bool)
    blocked[np.arange(30), np.arange(30)] = True
    squares = blocked_squares(blocked)
    rng = np.random.default_rng(0)
    for above, below in rng.uniform(0.8, 5.0, (200, 2)):
        middle = rng.uniform(6.0, 24.0)
        over, under = np.array([middle - above, middle]), np.array([middle, middle - below])
        assert not is_clear(squares, over, under, 1e-6)
