"""Replanning: which route is kept, which is replaced, and why."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.blocked_squares import blocked_squares, path_clearance
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap, from_boxes
from handcart.robotics.navigation.routes.replanning import Replanner, free_length
from handcart.robotics.navigation.routes.shortcuts import path_length

START, GOAL = Pose2(1.0, 2.0, 0.0), Pose2(7.0, 2.0, 0.0)
RADIUS = 0.3


def room(*boxes: FloorBox, cell: float = 0.05) -> GridMap:
    """8 x 4 m with walls and boxes."""
    walls = [FloorBox(4.0, y, 0.0, 8.0, 0.1) for y in (0.0, 4.0)] + [
        FloorBox(x, 2.0, 0.0, 0.1, 4.0) for x in (0.0, 8.0)
    ]
    return from_boxes([*walls, *boxes], cell, (-0.2, -0.2), (8.4, 4.4))


@pytest.fixture
def replanner() -> Replanner:
    return Replanner(RADIUS)


def test_a_free_route_is_kept_though_another_is_as_good(replanner: Replanner) -> None:
    grid = room(FloorBox(4.0, 2.0, 0.0, 0.6, 0.6))  # two ways of about the same cost
    first = replanner.look(grid, START, GOAL)
    assert first.kind == "new"
    mirrored = first.points * [1.0, -1.0] + [0.0, 4.0]
    for route in (first.points, mirrored):
        assert replanner.look(grid, START, GOAL, route=route).kind == "kept"


def test_a_blocked_route_is_replaced_with_its_beginning_kept(replanner: Replanner) -> None:
    route = replanner.look(room(), START, GOAL).points
    grid = room(FloorBox(4.0, 2.0, 0.0, 0.5, 1.0))
    look = replanner.look(grid, START, GOAL, route=route, lead=0.5)
    assert look.kind == "new"
    assert np.allclose(look.points[: len(route) // 20], route[: len(route) // 20])
    gaps = np.abs(look.points - (4.0, 2.0)) - (0.25, 0.5)
    assert np.hypot(*np.maximum(gaps, 0.0).T).min() > RADIUS


def test_a_closed_wall_leaves_no_way_and_reports_where(replanner: Replanner) -> None:
    route = replanner.look(room(), START, GOAL).points
    look = replanner.look(room(FloorBox(5.0, 2.0, 0.0, 0.1, 4.0)), START, GOAL, route=route)
    assert look.kind == "none"
    assert look.obstacle is not None
    assert 4.0 < look.obstacle[0] < 5.0
    assert look.free == pytest.approx(look.obstacle[0] - START.x, abs=0.1)


def test_an_off_route_robot_gets_a_new_route(replanner: Replanner) -> None:
    grid = room()
    route = replanner.look(grid, START, GOAL).points
    look = replanner.look(grid, Pose2(1.0, 3.0, 0.0), GOAL, route=route, better=False)
    assert look.kind == "new"
    assert math.dist(look.points[0], (1.0, 3.0)) < 0.1


def test_a_long_roomy_way_gives_way_to_a_short_narrow_one() -> None:
    gap = 2 * RADIUS + 0.1  # too narrow for the first room, wide enough for the second
    upper, lower = 2.0 + gap / 2, 2.0 - gap / 2
    wall = [
        FloorBox(4.0, (upper + 4.0) / 2, 0.0, 0.2, 4.0 - upper),
        FloorBox(4.0, (1.2 + lower) / 2, 0.0, 0.2, lower - 1.2),
    ]
    grid, start, goal = room(*wall), Pose2(3.2, 2.0, 0.0), Pose2(4.8, 2.0, 0.0)
    roomy = Replanner(RADIUS, rooms=(0.06,)).look(grid, start, goal)
    assert path_length(roomy.points) > 3.0  # along the lower wall
    look = Replanner(RADIUS, rooms=(0.06, 0.005)).look(grid, start, goal)
    assert path_length(look.points) < 1.8


def test_speeds_fall_with_the_room_beside_the_footprint(replanner: Replanner) -> None:
    look = replanner.look(room(), START, GOAL)
    middle, near = look.speeds.at(np.array([[4.0, 2.0], [4.0, 0.05 + RADIUS]]), 2.0)
    assert middle == 2.0
    assert 0.3 <= near < 0.7


def test_shorter_way_that_opens_is_taken_though_the_old_is_free(replanner: Replanner) -> None:
    """The map has changed between the looks; on an unchanged one nothing is planned again."""
    closed = room(FloorBox(4.0, 1.5, 0.0, 0.2, 3.0))
    long = replanner.look(closed, START, GOAL)
    assert replanner.look(closed, START, GOAL, route=long.points).kind == "kept"
    look = replanner.look(room(), START, GOAL, route=long.points)
    assert look.kind == "new"
    assert path_length(look.points) < path_length(long.points)


def test_steps_of_a_look_give_what_the_look_gives() -> None:
    """A gap with little room takes a step for each room that is tried."""
    gap = [FloorBox(4.0, y, 0.0, 0.2, 1.64) for y in (0.82, 3.18)]
    looking, count = Replanner(RADIUS).looking(room(*gap), START, GOAL), 0
    while True:
        try:
            next(looking)
            count += 1
        except StopIteration as end:
            found = end.value
            break
    whole = Replanner(RADIUS).look(room(*gap), START, GOAL)
    assert count > 0
    assert found.kind == whole.kind == "new"
    assert np.array_equal(found.points, whole.points)


def test_plan_on_a_large_map_takes_a_step_for_each_of_its_parts() -> None:
    """A period computes distances, thins, traces lines, searches or rounds; a small map takes one period."""
    for cell, parts in ((0.05, 1), (0.02, 5)):
        grid = room(FloorBox(4.0, 2.0, 0.0, 0.6, 0.6), cell=cell)
        looking, steps = Replanner(RADIUS).looking(grid, START, GOAL), 1
        while True:
            try:
                next(looking)
                steps += 1
            except StopIteration as end:
                found = end.value
                break
        assert steps == parts
        assert np.array_equal(found.points, Replanner(RADIUS).look(grid, START, GOAL).points)


@pytest.mark.parametrize("seed", range(6))
def test_free_length_is_that_by_all_cells_of_the_map(seed: int) -> None:
    """The part of the map that it looks at leaves out nothing that matters, and its edge is no obstacle."""
    random = np.random.default_rng(seed)
    places = random.uniform((0.5, 0.5), (7.5, 3.5), (12, 2)).tolist()
    grid = room(*(FloorBox(x, y, 0.0, 0.2, 0.2) for x, y in places))
    squares = blocked_squares(grid.blocked)
    for _ in range(40):
        start, end = random.uniform((0.1, 0.1), (7.9, 3.9), (2, 2))
        route = np.linspace(start, end, 20)
        cells = (route[:, ::-1] - (grid.origin_y, grid.origin_x)) / grid.resolution - 0.5
        clearance = path_clearance(squares, cells) * grid.resolution
        leaving = np.logical_and.accumulate(
            (clearance < RADIUS) & (np.maximum.accumulate(clearance) <= clearance + 1e-6)
        )
        tight = (clearance < RADIUS) & ~leaving
        found = free_length(grid, route, RADIUS)[1]
        assert found == (tuple(route[np.argmax(tight)]) if tight.any() else None)
