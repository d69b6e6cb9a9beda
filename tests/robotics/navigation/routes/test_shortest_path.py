import numpy as np
import pytest

from handcart.robotics.navigation.routes.shortest_path import shortest_path


def length(corners: np.ndarray) -> float:
    return float(np.hypot(*np.diff(corners, axis=0).T).sum())


def test_in_the_open_it_is_a_straight_line() -> None:
    path = shortest_path(np.ones((50, 80), dtype=bool), np.array([3, 4]), np.array([41, 77]))
    assert path is not None
    assert path.tolist() == [[3, 4], [41, 77]]


@pytest.mark.parametrize("gap", [2, 20, 45])
def test_around_a_wall_it_touches_the_corner(gap: int) -> None:
    free = np.ones((60, 80), dtype=bool)
    free[gap:, 40] = False
    start, goal = np.array([50, 10]), np.array([50, 70])
    path = shortest_path(free, start, goal)
    assert path is not None
    best = np.hypot(50 - gap, 29) + np.hypot(50 - gap, 29) + 2.0
    assert length(path) <= 1.01 * best


def test_none_where_there_is_no_way() -> None:
    free = np.ones((20, 20), dtype=bool)
    free[:, 10] = False
    assert shortest_path(free, np.array([5, 5]), np.array([5, 15])) is None
