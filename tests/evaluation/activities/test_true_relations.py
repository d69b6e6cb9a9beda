"""Relations between true bodies, by the definitions of BEHAVIOR-1K's simulator."""

from __future__ import annotations

import pytest

from handcart.evaluation.activities.true_relations import (
    TrueThing,
    is_inside,
    is_next_to,
    is_on_top,
    is_touching,
    is_under,
)
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

BOARD, SIDE, LID = (1.0, 0.3, 0.02), (0.02, 0.3, 0.5), (1.0, 0.3, 0.02)
SHELF = TrueThing(
    "shelf",
    (
        Box(transform((0.0, 0.0, 0.59)), BOARD, "board"),
        Box(transform((-0.49, 0.0, 0.85)), SIDE, "left"),
        Box(transform((0.49, 0.0, 0.85)), SIDE, "right"),
        Box(transform((0.0, 0.0, 1.11)), LID, "top"),
    ),
)


def book(x: float, y: float, foot: float, yaw: float = 0.0) -> TrueThing:
    return TrueThing(
        "book", (Box(transform((x, y, foot + 0.1), (0.0, 0.0, yaw)), (0.03, 0.15, 0.2), "book"),)
    )


@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_thing_between_boards_is_inside_and_not_on_top(yaw: float) -> None:
    thing = book(0.1, 0.0, 0.6, yaw)
    assert is_inside(thing, SHELF)
    assert not is_on_top(thing, SHELF)
    assert is_touching(thing, SHELF)


def test_thing_on_the_lid_is_on_top_and_not_inside() -> None:
    thing = book(0.1, 0.0, 1.12)
    assert is_on_top(thing, SHELF)
    assert not is_inside(thing, SHELF)


@pytest.mark.parametrize(("x", "y", "foot"), [(0.1, 0.3, 0.6), (0.6, 0.0, 0.6), (0.1, 0.0, 0.0)])
def test_thing_before_beside_or_below_is_not_inside(x: float, y: float, foot: float) -> None:
    assert not is_inside(book(x, y, foot), SHELF)


def test_thing_held_over_a_lid_is_not_on_top() -> None:
    assert not is_on_top(book(0.1, 0.0, 1.14), SHELF)


def test_thing_in_a_box_without_a_lid_is_inside() -> None:
    walls = [((0.2, 0.0), (0.02, 0.4)), ((-0.2, 0.0), (0.02, 0.4)), ((0.0, 0.2), (0.4, 0.02))]
    sides = [Box(transform((*at, 0.1)), (*size, 0.2), "side") for at, size in walls]
    last = Box(transform((0.0, -0.2, 0.1)), (0.4, 0.02, 0.2), "side")
    thing = TrueThing("jar", (Box(transform((0.05, 0.05, 0.06)), (0.06, 0.06, 0.1), "jar"),))
    assert is_inside(thing, TrueThing("box", (*sides, last)))
    assert not is_inside(thing, TrueThing("gap", tuple(sides[:2])))  # between two walls, with nothing above


def test_neighbours_within_a_sixth_of_their_size_are_next_to() -> None:
    one = book(0.0, 0.0, 0.6)  # a sixth of the mean of both sizes is 42 mm
    assert is_next_to(one, book(0.07, 0.0, 0.6))
    assert not is_next_to(one, book(0.08, 0.0, 0.6))
    assert not is_next_to(one, book(0.0, 0.0, 0.81))  # above it, and in no level direction


def test_floor_board_is_under_what_it_does_not_carry() -> None:
    mat = TrueThing("mat", (Box(transform((0.0, 0.0, 0.005)), (0.2, 0.2, 0.01), "mat"),))
    assert is_under(mat, SHELF)
    assert not is_under(SHELF, mat)
