"""Cells of a map near things that may have moved since it was made."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.map_window import coarsened, window_around
from handcart.robotics.navigation.maps.movable_areas import MovableArea, with_movable

NOTHING = np.zeros((60, 80), dtype=np.bool_)
GRID = GridMap(NOTHING, NOTHING, 0.05, -1.0, 2.0)
TABLE = np.array([[0.5, 3.0], [1.5, 3.0], [1.5, 3.5], [0.5, 3.5]])


def test_cells_within_the_margin_of_an_outline_are_marked() -> None:
    marked = with_movable(GRID, [MovableArea(TABLE, 0.2)]).movable
    assert marked is not None
    points = GRID.to_point(np.argwhere(marked))
    assert points.min(axis=0) == pytest.approx((0.5 - 0.2, 3.0 - 0.2), abs=0.08)
    assert points.max(axis=0) == pytest.approx((1.5 + 0.2, 3.5 + 0.2), abs=0.08)
    inside = GRID.to_cell(np.array([[1.0, 3.2], [0.35, 3.2], [1.0, 3.65], [0.2, 3.2], [1.0, 3.9]]))
    assert marked[tuple(inside.T)].tolist() == [True, True, True, False, False]
    corner = GRID.to_cell(np.array([[0.5 - 0.19, 3.0 - 0.19]]))[0]  # round corners: 0.27 m away
    assert not marked[tuple(corner)]


def test_areas_that_the_lidar_does_not_meet_are_ignored() -> None:
    drawer, bin_ = MovableArea(TABLE, 0.1, 0.75, 0.95), MovableArea(TABLE, 0.1, 0.0, 0.18)
    assert with_movable(GRID, [drawer, bin_], 0.4).movable is None
    for height in (0.2, 0.72, 0.98):
        assert with_movable(GRID, [drawer, bin_], height).movable is not None
    assert with_movable(with_movable(GRID, [bin_], 0.1), [], 0.1).movable is None
    beyond = with_movable(
        GRID, [MovableArea(TABLE + np.array([2.6, 0.0]), 0.2)]
    ).movable  # it begins 0.1 m off the map
    assert beyond is not None
    assert GRID.to_point(np.argwhere(beyond))[:, 0].min() == pytest.approx(3.1 - 0.2, abs=0.08)
    away = with_movable(GRID, [MovableArea(TABLE + 90.0, 0.1)]).movable
    assert away is not None and not away.any()


def test_windows_and_wider_cells_keep_the_marks() -> None:
    grid = with_movable(GRID, [MovableArea(TABLE, 0.2)])
    assert grid.movable is not None
    window = window_around(grid, 1.0, 3.0, 0.4)
    centres = window.to_point(np.argwhere(np.ones(window.occupied.shape, dtype=np.bool_)))
    assert window.movable is not None
    assert np.array_equal(window.movable.ravel(), grid.movable[tuple(grid.to_cell(centres).T)])
    wide = coarsened(grid, 4)
    assert wide.movable is not None
    assert wide.movable[tuple(wide.to_cell(grid.to_point(np.argwhere(grid.movable))).T)].all()
    assert wide.movable.sum() < 0.2 * grid.movable.sum()
    assert grid.with_points(np.array([[0.0, 3.0]])).movable is grid.movable
