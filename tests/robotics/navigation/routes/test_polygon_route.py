"""Routes of polygons, which pass where a disc around them does not."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.driving.doors import LENGTH_M, WIDTH_M, make_doorway
from handcart.robotics.geometry.footprint import polygon
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.routes.replanning import Replanner
from handcart.robotics.navigation.routes.route import Route
from handcart.robotics.navigation.routes.straight_pass import straight_passes
from handcart.robotics.navigation.routes.swept_route import MAX_ROOM_M, swept_room
from handcart.robotics.navigation.routes.ways import Ways
from handcart.robotics.numerics.stepwise import finish

SHAPE = polygon(np.array([[0.25, 0.215], [-0.25, 0.215], [-0.25, -0.215], [0.25, -0.215]]))
START, GOAL = Pose2(1.0, 2.0, 0.0), Pose2(5.0, 2.0, 0.0)


def rooms(door: float, middle: float = 1.0, cell: float = 0.05) -> GridMap:
    """Two rooms of 3 x 4 m, and a door in the wall between them."""
    low, high = middle - door / 2, middle + door / 2
    walls = [
        (3.0, 0.0, 0.0, 6.1, 0.1),
        (3.0, 4.0, 0.0, 6.1, 0.1),
        (0.0, 2.0, 0.0, 0.1, 4.1),
        (6.0, 2.0, 0.0, 0.1, 4.1),
        (3.0, low / 2, 0.0, 0.1, low),
        (3.0, (4.0 + high) / 2, 0.0, 0.1, 4.0 - high),
    ]
    return from_boxes(walls, cell, (-0.2, -0.2), (6.4, 4.4))


def route_to_goal(ways: Ways) -> Route | None:
    return finish(ways.routing_to(GOAL))


@pytest.mark.parametrize("door", [0.55, 0.7])
def test_route_leads_straight_through_a_door_of_its_width(door: float) -> None:
    grid = rooms(door)
    route = route_to_goal(Ways(grid, SHAPE, START))
    assert route is not None
    inner = np.hypot(*(route.points - START[:2]).T) > 0.4
    inner &= np.hypot(*(route.points - GOAL[:2]).T) > 0.4
    assert swept_room(grid, SHAPE, route.points)[inner].min() > 0.0
    assert route_to_goal(Ways(grid, SHAPE.radius, START)) is None


def test_door_narrower_than_the_rectangle_has_no_route() -> None:
    way = Ways(rooms(0.25), SHAPE, START).to(GOAL)
    assert way.route is None
    assert way.why == "too narrow"
    assert way.narrow == pytest.approx((3.0, 1.0), abs=0.1)


def test_corner_that_only_a_disc_takes_is_avoided() -> None:
    """A gap of 0.55 m leads into a wall 0.75 m behind it: the inscribed disc turns there, the box cannot."""
    long = polygon(np.array([[0.6, 0.215], [-0.6, 0.215], [-0.6, -0.215], [0.6, -0.215]]))
    baffle = (3.35, 1.0, 0.0, 0.1, 1.2)
    occupied = rooms(0.55).occupied | from_boxes([baffle], 0.05, (-0.2, -0.2), (6.4, 4.4)).occupied
    grid = rooms(0.55)._replace(occupied=occupied)
    wide = grid._replace(occupied=grid.occupied & ~_door_at(grid, 3.2))
    disc, box = (route_to_goal(Ways(wide, shape, START)) for shape in (long.inscribed, long))
    assert disc is not None
    assert box is not None
    inner = (np.hypot(*(box.points - START[:2]).T) > 0.4) & (np.hypot(*(box.points - GOAL[:2]).T) > 0.4)
    assert swept_room(wide, long, box.points)[inner].min() > 0.0


def _door_at(grid: GridMap, y: float) -> np.ndarray:
    """(h, w) cells of the wall between the rooms within 0.4 m of a height on the map."""
    rows, columns = np.indices(grid.occupied.shape)
    at = grid.to_point(np.column_stack([rows.ravel(), columns.ravel()])).reshape(*rows.shape, 2)
    return np.asarray((abs(at[..., 0] - 3.0) < 0.15) & (abs(at[..., 1] - y) < 0.4))


def test_swept_room_is_that_of_the_corners_in_a_turn() -> None:
    grid = rooms(0.7)
    straight = np.column_stack([np.linspace(1.0, 2.0, 21), np.full(21, 0.32)])
    along = swept_room(grid, SHAPE, straight)
    turned = swept_room(grid, SHAPE, straight[:1], heading=0.5 * np.pi)
    assert along.min() == pytest.approx(0.32 - 0.05 - 0.215, abs=0.01)
    assert turned.min() < along.min() - 0.05
    assert swept_room(grid, SHAPE, straight + np.array([0.5, 1.5])).min() == pytest.approx(MAX_ROOM_M)


def test_look_keeps_a_route_only_while_the_rectangle_passes() -> None:
    grid = rooms(0.7)
    planner = Replanner(SHAPE)
    first = planner.look(grid, START, GOAL)
    assert first.kind == "new"
    assert planner.look(grid, START, GOAL, route=first.points, better=False).kind == "kept"
    post = np.array([[3.0, 0.72]])  # 5 cm into the door
    assert (
        planner.look(grid.with_points(post, 0.06), START, GOAL, route=first.points, better=False).kind
        != "kept"
    )


@pytest.mark.parametrize("door", [0.49, 0.53])
def test_door_in_a_turned_wall_is_passed_wherever_cells_lie(door: float) -> None:
    for seed in range(230, 260):
        doorway = make_doorway(seed, door)
        shift = np.random.default_rng(seed).uniform(-0.05, 0.0, 2) - 0.3
        corner = float(shift[0]), float(shift[1])
        grid = from_boxes(doorway.walls, 0.05, corner, (LENGTH_M + 0.7, WIDTH_M + 0.7))
        way = Ways(grid, SHAPE, Pose2(*doorway.start)).to(Pose2(*doorway.goal))
        assert way.route is not None, (seed, way.reason)
        inner = np.hypot(*(way.route.points - doorway.start[:2]).T) > 0.4
        inner &= np.hypot(*(way.route.points - doorway.goal[:2]).T) > 0.4
        assert swept_room(grid, SHAPE, way.route.points)[inner].min() > -0.046


def test_turned_door_narrower_than_the_rectangle_is_refused() -> None:
    for seed in range(200, 210):
        doorway = make_doorway(seed, 0.36)
        grid = from_boxes(doorway.walls, 0.05, (-0.31, -0.33), (LENGTH_M + 0.7, WIDTH_M + 0.7))
        assert Ways(grid, SHAPE, Pose2(*doorway.start)).to(Pose2(*doorway.goal)).why == "too narrow"


def test_straight_pass_is_in_the_middle_and_across_the_door() -> None:
    grid = rooms(0.6)
    askew = np.column_stack([np.linspace(1.0, 5.0, 81), np.linspace(0.7, 1.3, 81)])
    for points in straight_passes(grid, SHAPE, askew, askew[40]):
        inside = np.abs(points[:, 0] - 3.0) < 0.3
        assert np.abs(points[inside, 1] - 1.0).max() < 0.03
        assert np.hypot(*np.diff(points, axis=0).T).max() < 0.051
        assert points[[0, -1]].tolist() == askew[[0, -1]].tolist()
