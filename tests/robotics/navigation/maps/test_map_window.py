"""Windows of a map, and maps with larger cells."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.map_window import (
    coarsened,
    is_within,
    window_around,
    with_cells_at,
)


def random_map(seed: int = 4, shape: tuple[int, int] = (47, 62)) -> GridMap:
    rng = np.random.default_rng(seed)
    occupied = rng.random(shape) < 0.05
    return GridMap(occupied, (rng.random(shape) < 0.05) & ~occupied, 0.1, -1.3, 2.0)


def test_window_has_the_same_cells_at_the_same_places() -> None:
    grid = random_map()
    window = window_around(grid, 1.0, 4.0, 0.9)
    centres = window.to_point(np.argwhere(np.ones(window.occupied.shape, dtype=np.bool_)))
    assert len(centres) >= 19**2
    assert np.abs(centres - (1.0, 4.0)).max() < 0.9 + grid.resolution
    rows, columns = grid.to_cell(centres).T
    assert np.array_equal(grid.occupied[rows, columns], window.occupied.ravel())
    assert np.array_equal(grid.unknown[rows, columns], window.unknown.ravel())


def test_window_beyond_the_map_ends_with_it() -> None:
    grid = random_map()
    window = window_around(grid, -1.3, 2.0, 1.0)
    assert (window.origin_x, window.origin_y) == (grid.origin_x, grid.origin_y)
    assert window_around(grid, 0.0, 0.0, 99.0).occupied.shape == grid.occupied.shape


def test_larger_cells_hold_whatever_any_of_theirs_holds() -> None:
    grid = random_map()
    coarse = coarsened(grid, 4)
    assert coarse.occupied.shape == (12, 16)
    assert coarse.resolution == 0.4
    for row, column in np.ndindex(12, 16):
        part = np.s_[4 * row : 4 * row + 4, 4 * column : 4 * column + 4]
        beyond = 4 * row + 4 > 47 or 4 * column + 4 > 62
        assert coarse.occupied[row, column] == grid.occupied[part].any()
        assert coarse.blocked[row, column] == (grid.blocked[part].any() or beyond)


def test_sensed_cells_are_added_and_the_map_stays() -> None:
    grid = random_map()
    before = grid.occupied.copy()
    points = np.array([[0.0, 3.0], [1.0, 4.0], [99.0, 0.0]])
    found = with_cells_at(grid, points)
    rows, columns = grid.to_cell(points[:2]).T
    assert found.occupied[rows, columns].all()
    assert not found.unknown[rows, columns].any()
    assert np.array_equal(grid.occupied, before)
    assert is_within(grid, points, 0.2).tolist() == [True, True, False]
