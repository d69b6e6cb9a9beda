"""Rectangles that cover the occupied cells of a map near a point."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.maps.map_boxes import boxes_near

CELL_M = 0.05
SIZE_M = (4.0, 3.0)
ORIGIN_M = (-1.0, 2.0)


def drawn(*boxes: tuple[float, float, float, float, float]) -> GridMap:
    return from_boxes(boxes, CELL_M, ORIGIN_M, SIZE_M)


def test_boxes_cover_the_occupied_cells_exactly() -> None:
    occupied = np.random.default_rng(4).random((60, 80)) < 0.02
    grid = GridMap(occupied, np.zeros_like(occupied), CELL_M, *ORIGIN_M)
    found = boxes_near(grid, (1.0, 3.5), 5.0, [], most=10_000)
    less = [(x, y, yaw, length - 0.01, width - 0.01) for x, y, yaw, length, width in found]
    assert np.array_equal(drawn(*less).occupied, occupied)


def test_straight_wall_is_one_box_up_to_the_reach() -> None:
    grid = drawn((1.0, 4.525, 0.0, 3.9, 0.04))
    (wall,) = boxes_near(grid, (1.0, 3.5), 1.1, [])
    assert wall.length == pytest.approx(2.2, abs=2.1 * CELL_M)
    assert (wall.y, wall.width) == pytest.approx((4.525, CELL_M))
    assert boxes_near(grid, (1.0, 3.5), 0.9, []) == []


@pytest.mark.parametrize(("margin", "count"), [(0.08, 0), (0.0, 1)])
def test_outline_hides_cells_up_to_its_margin(margin: float, count: int) -> None:
    grid = drawn((1.0, 4.025, 0.0, 1.0, 0.04))
    below = np.array([[0.0, 3.0], [2.0, 3.0], [2.0, 3.95], [0.0, 3.95]])
    assert len(boxes_near(grid, (1.0, 3.5), 1.4, [below], margin)) == count


def test_slanted_wall_is_covered_by_few_boxes() -> None:
    grid = drawn((1.0, 3.5, 0.7, 2.4, 0.04))
    found = boxes_near(grid, (1.0, 3.5), 2.0, [], most=12)
    assert 1 < len(found) <= 12
    assert not (grid.occupied & ~drawn(*found).occupied).any()
