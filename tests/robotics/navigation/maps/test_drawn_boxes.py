import math

import numpy as np
import pytest

from handcart.robotics.navigation.maps.drawn_boxes import without_drawn_boxes
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap, from_boxes

CELL = 0.05
WALL = FloorBox(2.0, 3.0, 0.0, 4.0, 0.2)
OTHER_WALL = FloorBox(0.1, 2.0, 0.0, 0.2, 2.0)
COUNTER = FloorBox(1.0, 2.65, 0.0, 1.0, 0.5)  # at the wall


def drawn(*boxes: FloorBox) -> GridMap:
    return from_boxes(boxes, CELL, (0.0, 0.0), (4.0, 4.0))


@pytest.mark.parametrize("turn_deg", [0, 30, 90])
def test_a_box_in_the_open_disappears_from_its_map(turn_deg: float) -> None:
    box = FloorBox(2.0, 1.5, math.radians(turn_deg), 0.8, 0.5)
    assert not without_drawn_boxes(drawn(box), [box]).occupied.any()


def test_a_box_drawn_as_outline_and_too_large_disappears() -> None:
    box = FloorBox(2.0, 1.5, 0.0, 0.8, 0.5)
    filled = drawn(FloorBox(2.0, 1.5, 0.0, 0.8 + 2 * CELL, 0.5 + 2 * CELL))
    hollow = filled.occupied & ~drawn(FloorBox(2.0, 1.5, 0.0, 0.8, 0.5)).occupied
    assert hollow.any()
    assert not without_drawn_boxes(filled._replace(occupied=hollow), [box]).occupied.any()


def test_the_wall_behind_a_drawn_box_stays_a_closed_wall() -> None:
    left = without_drawn_boxes(drawn(WALL, COUNTER), [COUNTER]).occupied
    assert left[60].all()  # a row in the middle of the wall
    rows = drawn().to_cell(np.array([[1.0, 2.6]]))[0]
    assert not left[: rows[0] + 1].any()


def test_walls_around_a_box_that_is_not_drawn_stay() -> None:
    """A low box stands in a corner: two of its sides touch walls, which it did not make."""
    corner = FloorBox(0.5, 2.65, 0.0, 0.6, 0.5)
    walls = drawn(WALL, OTHER_WALL)
    assert np.array_equal(without_drawn_boxes(walls, [corner]).occupied, walls.occupied)


def test_a_box_off_the_map_frees_nothing() -> None:
    walls = drawn(WALL)
    assert np.array_equal(without_drawn_boxes(walls, [FloorBox(9, 9, 0, 1, 1)]).occupied, walls.occupied)
