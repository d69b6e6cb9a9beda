"""Frontiers: where a robot could drive on into the unknown, and no gap that is too narrow for it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.exploring.free_ground import with_driven, with_gaps_closed
from handcart.robotics.navigation.exploring.frontiers import Border, find_border, travel
from handcart.robotics.navigation.exploring.merged_map import merge_maps
from handcart.robotics.navigation.maps.grid_map import GridMap

NOTHING = np.empty((0, 2))
CELL_M = 0.05


def room(door_m: float) -> GridMap:
    """Return a known room of 4 x 4 m whose wall on the right has a gap into the unknown."""
    occupied = np.zeros((84, 110), dtype=np.bool_)
    unknown = np.ones((84, 110), dtype=np.bool_)
    unknown[:84, :84] = False
    occupied[[0, 1, 82, 83], :84] = occupied[:84, [0, 1, 82, 83]] = True
    half = round(0.5 * door_m / CELL_M)
    occupied[42 - half : 42 + half, 82:84] = False
    return GridMap(occupied, unknown, CELL_M, 0.0, 0.0)


def border(grid: GridMap, radius: float, left: np.ndarray = NOTHING) -> Border:
    return find_border(grid, radius, (1.0, 1.0), left, 0.5)


@pytest.mark.parametrize(("door_m", "count"), [(0.5, 0), (1.0, 1)])
def test_frontier_is_a_gap_that_the_robot_fits_through(door_m: float, count: int) -> None:
    found = border(room(door_m), 0.3)
    assert len(found.frontiers) == count
    assert found.cells == round(door_m / CELL_M)
    assert (found.passable > 0) == (count > 0)


def test_frontier_is_looked_at_from_a_place_where_the_robot_fits() -> None:
    found = border(room(1.0), 0.3).frontiers[0]
    assert found.middle == pytest.approx((4.17, 2.1), abs=0.06)
    assert found.view is not None
    assert found.view[0] < 4.2 - 0.3
    assert abs(found.view[1] - 2.1) < 0.3
    assert found.distance == pytest.approx(math.hypot(2.7, 1.1), rel=0.1)


def test_edge_of_the_map_is_a_frontier() -> None:
    """Maps are cut where nothing more was hit: beams into the open end beyond."""
    grid = room(1.0)
    cut = GridMap(grid.occupied[:, :84], grid.unknown[:, :84], CELL_M, 0.0, 0.0)
    found = border(cut, 0.3).frontiers
    assert len(found) == 1
    assert found[0].middle == pytest.approx((4.17, 2.1), abs=0.06)
    assert found[0].view is not None
    assert found[0].view[0] < 4.2 - 0.3


def test_frontier_behind_a_narrow_passage_has_no_view() -> None:
    """A wall across the room leaves a slit, through which the robot sees the door and cannot come."""
    grid = room(1.0)
    grid.occupied[2:82, 50:52] = True
    grid.occupied[40:44, 50:52] = False
    assert not border(grid, 0.3).frontiers  # nor could its middle be at the border
    grid.occupied[34:50, 50:52] = False
    grid.unknown[20:64, 44:48] = True
    found = border(grid, 0.3).frontiers
    assert found
    assert all(frontier.view is None or frontier.view[0] < 2.0 for frontier in found)


def test_border_around_a_left_point_is_counted_and_not_driven_to() -> None:
    found = border(room(1.0), 0.3, np.array([[4.2, 2.1]]))
    assert found.frontiers == []
    assert found.left[0] == found.passable
    assert found.small == 0


def test_gaps_between_beams_are_free_and_the_inside_of_walls_is_not() -> None:
    grid = room(1.0)
    grid.unknown[30:50:3, 20:22] = True
    grid.occupied[60:64, 20:40] = True
    grid.occupied[61:63, 21:39], grid.unknown[61:63, 21:39] = False, True
    grid.unknown[20:26, 60:66] = True
    found = with_gaps_closed(grid)
    assert not found.unknown[30:50, 20:22].any()
    assert found.unknown[61:63, 21:39].all()
    assert found.unknown[20:26, 60:66].any()
    assert found.unknown[:, 90:].all()


def test_unknown_spot_smaller_than_the_robot_is_no_frontier() -> None:
    grid = room(0.0)
    grid.unknown[60:62, 20:22] = True
    found = border(grid, 0.3)
    assert found.frontiers == []
    assert found.small == found.cells == 12


def test_travel_goes_around_walls() -> None:
    free = np.ones((30, 30), dtype=np.bool_)
    free[5:, 15] = False
    lengths = travel(free, 20, 10)
    assert lengths[20, 20] == pytest.approx(2 * (5 * math.sqrt(2) + 11))
    free[:, 15] = False
    assert math.isinf(travel(free, 20, 10)[20, 20])


def test_ground_below_the_robot_is_free() -> None:
    grid = room(1.0)
    grid.unknown[10:30, 10:30] = True
    found = with_driven(grid, [Pose2(1.0, 1.0, 0.0)], 0.3)
    assert not found.unknown[20, 20]
    assert found.unknown[12, 12]


def test_merged_map_shows_the_other_where_nothing_is_drawn() -> None:
    drawn = room(1.0)
    other = GridMap(np.zeros((50, 50), np.bool_), np.zeros((50, 50), np.bool_), 0.1, 3.0, -1.0)
    other.occupied[10, 40] = True
    merged = merge_maps(drawn, other)
    at = merged.to_cell(np.array([[7.05, 0.05], [7.5, 3.0], [4.15, 0.05], [1.0, 1.0], [-0.5, -0.5]]))
    assert merged.occupied[tuple(at[:3].T)].tolist() == [True, False, True]
    assert merged.unknown[tuple(at[:4].T)].tolist() == [False] * 4
    assert merged.inside(np.array([[7.9, 3.9], [3.1, -0.9]])).all()
    assert (drawn.occupied == room(1.0).occupied).all()
