"""Places and routes of a round robot, and reasons for the missing ones."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.routes.ways import ROOM_AT_GOAL, Ways

RADIUS = 0.3
START = (1.0, 2.0)


def two_rooms(door: float, cell: float = 0.05) -> GridMap:
    """Rooms of 3 m by 4 m, a wall of 0.2 m between them with a door in its middle, this wide in [m]."""
    side = (4.0 - door) / 2.0
    walls = [
        (3.1, 0.05, 0.0, 6.2, 0.1),
        (3.1, 3.95, 0.0, 6.2, 0.1),
        (0.05, 2.0, 0.0, 0.1, 4.0),
        (6.15, 2.0, 0.0, 0.1, 4.0),
        (3.1, side / 2.0, 0.0, 0.2, side),
        (3.1, 4.0 - side / 2.0, 0.0, 0.2, side),
    ]
    return from_boxes(walls, cell, (0.0, 0.0), (6.2, 4.0))


def test_a_goal_with_room_is_reached_by_a_route_that_keeps_it() -> None:
    grid = two_rooms(1.0)
    way = Ways(grid, RADIUS, START).to((5.0, 1.0))
    assert (way.why, way.component, way.reason) == ("", 1, "")
    assert way.clearance == pytest.approx(0.9)
    assert way.route is not None
    assert Clearances(grid).at(way.route.points).min() >= RADIUS
    assert way.route.points[-1] == pytest.approx([5.0, 1.0])


@pytest.mark.parametrize("cell", [0.05, 0.1, 0.2])
def test_a_goal_may_be_as_near_as_is_needed_and_no_nearer(cell: float) -> None:
    """The wall's cells end at 0.1 m, or where the cell does that it runs through."""
    ways, wall = Ways(two_rooms(1.2, cell), RADIUS, START), max(0.1, cell)
    needed = RADIUS + ROOM_AT_GOAL + 0.5 * (cell - 0.05)
    allowed, refused = (ways.to((2.0, wall + needed + off)) for off in (0.0011, -0.0011))
    assert (allowed.fits, refused.fits, refused.why) == (True, False, "too near")
    assert allowed.route is not None
    assert allowed.route.clearance.min() >= RADIUS
    room = f"leaves {needed - 0.0011:.3f} m to its middle, needed: {needed:.3f} m"
    assert refused.reason == f"something at (2.00, {wall:.2f}) m {room}"


def test_a_door_that_is_too_narrow_is_told_with_its_place_and_width() -> None:
    way = Ways(two_rooms(0.5), RADIUS, START).to((5.0, 1.0))
    assert (way.why, way.route) == ("too narrow", None)
    assert way.narrow is not None
    assert 3.0 <= way.narrow[0] <= 3.2
    assert way.narrow[1] == pytest.approx(2.0, abs=0.06)
    assert way.width == pytest.approx(0.5, abs=0.01)
    assert way.width_needed == pytest.approx(0.64)
    assert "the way is too narrow: 0.50 m wide at (3." in way.reason


def test_what_no_free_space_leads_to_is_cut_off() -> None:
    assert Ways(two_rooms(0.0), RADIUS, START).to((5.0, 1.0)).why == "cut off"


def test_parts_of_the_map_are_numbered_by_size() -> None:
    ways = Ways(two_rooms(0.0), RADIUS, START)
    boxed = from_boxes([(1.5, 3.0, 0.0, 3.0, 0.1)], 0.05, (0.0, 0.0), (6.2, 4.0))
    grid = two_rooms(0.0)
    smaller = Ways(grid._replace(occupied=grid.occupied | boxed.occupied), RADIUS, START)
    assert {ways.to((1.0, 2.0)).component, ways.to((5.0, 1.0)).component} == {1, 2}
    assert (smaller.to((1.0, 1.0)).component, smaller.to((5.0, 1.0)).component) == (2, 1)


def test_unknown_space_and_the_edge_of_the_map_leave_no_room_either() -> None:
    grid = two_rooms(1.0)
    unknown = np.zeros_like(grid.unknown)
    unknown[20:30, 20:30] = True
    ways = Ways(grid._replace(unknown=unknown), RADIUS, START)
    assert ways.to((1.25, 0.8)).reason.startswith("unknown space at (1.25, 1.00) m")
    nothing = np.zeros((40, 40), np.bool_)
    empty = Ways(GridMap(nothing, nothing, 0.1, 0.0, 0.0), RADIUS, START)
    assert empty.to((0.2, 2.0)).reason.startswith("the map's edge at (0.00, 2.00) m leaves 0.200 m")


def test_before_a_declared_front_its_real_distance_counts() -> None:
    """The front is at 0.07 m; its cells reach 3 cm farther out."""
    grid = from_boxes([(2.0, 0.02, 0.0, 4.0, 0.1)], 0.1, (0.0, -0.4), (4.0, 4.0))
    front = np.array([[1.5, 0.07], [2.5, 0.07]])
    ways = Ways(grid, RADIUS, START)
    assert ways.to((2.0, 0.4)).why == "too near"
    before = ways.to((2.0, 0.4), front)
    assert (before.why, before.kind) == ("", "its front")
    assert before.clearance == pytest.approx(0.33)
    assert before.route is not None
    nearer = ways.to((2.0, 0.38), front)
    assert nearer.why == "too near"
    assert nearer.needed == pytest.approx(0.32)
    beside = ways.to((3.2, 0.4), front)
    assert (beside.why, beside.kind) == ("too near", "something")


def test_route_keeps_clear_of_sensed_points_but_may_end_beside() -> None:
    sensed = np.array([[3.1, 2.0]])
    assert Ways(two_rooms(1.0), RADIUS, START, sensed).to((5.0, 1.0)).why == "too narrow"
    past = Ways(two_rooms(1.0), RADIUS, START, np.array([[5.0, 2.0]]))
    beside = past.to((5.0, 2.0 - 0.41))
    assert beside.route is not None
    assert np.hypot(*(beside.route.points - (5.0, 2.0)).T).min() > RADIUS
    assert past.to((5.0, 1.8)).why == "too near"


def test_room_between_sensed_points_and_a_wall_is_reduced() -> None:
    """Its far side wasn't seen."""
    clear, shown = two_rooms(1.4), two_rooms(1.4)
    shown.occupied[39:41, 61:63] = True
    assert Ways(shown, RADIUS, START).to((5.0, 1.0)).route is not None
    sensed = np.array([[3.1, 2.0]])
    assert Ways(clear, RADIUS, START, sensed).to((5.0, 1.0)).why == "too narrow"


def test_a_start_that_is_too_near_can_be_left() -> None:
    way = Ways(two_rooms(1.0), RADIUS, (0.35, 2.0)).to((5.0, 1.0))
    assert way.route is not None
    assert way.route.clearance[1:].min() >= 0.25 - 1e-6
