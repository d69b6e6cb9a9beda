"""Things that were measured elsewhere than the map shows them, drawn where they are."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.moved_things import MovedThing, beside, with_moved

SQUARE = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.0, 0.4]])


def grid_with_table() -> GridMap:
    """Return 2 m by 2 m with a table at (0.5, 0.5) and a wall 0.1 m behind it."""
    occupied = np.zeros((40, 40), dtype=np.bool_)
    occupied[10:18, 10:18] = True
    occupied[20, :] = True
    unknown = np.zeros_like(occupied)
    unknown[12:16, 12:16] = True
    return GridMap(occupied, unknown & ~occupied, 0.05, 0.0, 0.0)


def test_moved_thing_is_drawn_at_its_new_outline_only() -> None:
    grid = grid_with_table()
    moved = with_moved(grid, [MovedThing(SQUARE + 0.5, SQUARE + np.array([1.0, 0.4]))])
    assert not moved.blocked[10:18, 10:18].any()
    assert moved.occupied[20].all()  # the wall remains
    assert moved.occupied.sum() == 64 + 40
    assert moved.occupied[8:16, 20:28].all()
    assert grid.occupied[10:18, 10:18].all()  # the given map is unchanged
    assert with_moved(grid, []) is grid


def test_thing_beyond_the_map_is_cut_off() -> None:
    moved = with_moved(grid_with_table(), [MovedThing(SQUARE - 5.0, SQUARE + np.array([1.8, -0.2]))])
    assert moved.occupied[:4, 36:].all()
    assert moved.occupied.sum() == 64 + 40 + 16


def test_points_beside_an_outline_within_the_margin() -> None:
    points = np.array([[0.2, 0.2], [0.45, 0.2], [0.2, -0.04], [0.5, 0.2], [0.2, 0.47]])
    assert beside(points, SQUARE, 0.06).tolist() == [True, True, True, False, False]
    assert beside(points[:0], SQUARE, 0.06).shape == (0,)
