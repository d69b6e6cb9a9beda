"""Routes across large maps: larger cells far away, the map's own cells near by."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap, from_boxes
from handcart.robotics.navigation.maps.map_window import window_around
from handcart.robotics.navigation.routes import far_planning
from handcart.robotics.navigation.routes.far_planning import FarPlanner
from handcart.robotics.navigation.routes.far_replanning import FarReplanner
from handcart.robotics.navigation.routes.replanning import RouteLook
from handcart.robotics.navigation.routes.voronoi_graph import VoronoiGraph, voronoi_graph
from handcart.robotics.numerics.stepwise import finish

NOTHING = np.empty((0, 2))
RADIUS, HALF = 0.3, 6.0
START, GOAL = Pose2(2.0, 2.0, 0.0), Pose2(27.0, 17.0, 0.0)


@pytest.fixture(autouse=True)
def _small_maps_are_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells of 0.1 m become 0.3 m."""
    monkeypatch.setattr(far_planning, "COARSE_CELL_COUNT", 7_000)


def hall(*gaps: tuple[float, float]) -> GridMap:
    """30 x 20 m, and a wall across its middle with gaps: their y and width in [m]."""
    walls = [FloorBox(15.0, y, 0.0, 30.0, 0.2) for y in (0.1, 19.9)]
    walls += [FloorBox(x, 10.0, 0.0, 0.2, 20.0) for x in (0.1, 29.9)]
    begin = 0.0
    for y, width in (*gaps, (20.0, 0.0)):
        middle, length = 0.5 * (begin + y - 0.5 * width), y - 0.5 * width - begin
        walls.append(FloorBox(15.0, middle, 0.0, 0.3, length))
        begin = y + 0.5 * width
    return from_boxes(walls, 0.1, (0.0, 0.0), (30.0, 20.0))


def look(
    grid: GridMap, start: Pose2 = START, sensed: np.ndarray = NOTHING, route: np.ndarray | None = None
) -> RouteLook:
    replanner = FarReplanner(grid, Footprint(RADIUS), RADIUS, HALF, 1.0, None)
    window = window_around(grid, start.x, start.y, HALF).with_points(sensed)
    return finish(replanner.looking(window, sensed, start, GOAL, None, route, 0.0, True, 0.0))


def room_along(grid: GridMap, points: np.ndarray) -> float:
    steps = np.linspace(points[:-1], points[1:], 5).reshape(-1, 2)
    return float(Clearances(grid, grid.blocked, walled=True).at(steps).min())


def test_route_on_larger_cells_keeps_room_and_ends_at_the_goal() -> None:
    grid = hall((16.0, 1.6))
    found = look(grid)
    assert found.kind == "new"
    assert np.allclose(found.points[0], START[:2])
    assert np.allclose(found.points[-1], GOAL[:2])
    assert room_along(grid, found.points) > RADIUS
    assert np.hypot(*np.diff(found.points, axis=0).T).max() < 0.7


def test_route_that_is_free_is_kept_with_its_far_part() -> None:
    grid = hall((16.0, 1.6))
    route = look(grid).points
    again = look(grid, route=route)
    assert again.kind == "kept"
    assert np.array_equal(again.points, route)
    assert again.free > 25.0


def test_gap_that_larger_cells_close_is_found_on_the_map_s_own() -> None:
    grid = hall((16.0, 0.9))
    planner = FarPlanner(grid, Footprint(RADIUS), RADIUS, HALF)
    assert finish(planner.routing(START, GOAL, None, NOTHING)) is None
    found = look(grid)
    assert found.kind == "new"
    assert room_along(grid, found.points) > RADIUS


def test_closed_wall_has_no_way() -> None:
    assert look(hall()).kind == "none"


def test_route_that_cannot_be_reached_has_no_free_length() -> None:
    grid = hall((16.0, 1.6))
    route = look(grid, Pose2(4.0, 4.0, 0.0)).points
    aside = Pose2(5.5, 4.0, 0.0)
    assert np.hypot(*(route - aside[:2]).T).min() > 0.3
    across = np.column_stack([np.linspace(0.0, 30.0, 600), np.full(600, 6.0)])
    found = look(grid, aside, across, route)
    assert found.kind == "none"
    assert found.free == 0.0


def test_route_planned_while_a_graph_is_built_is_on_that_map(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a real robot a thread may still build the graph when the next one plans."""
    grid = hall((16.0, 1.6))
    planner, build = FarPlanner(grid, Footprint(RADIUS), RADIUS, HALF), voronoi_graph
    meanwhile: list[np.ndarray | None] = []

    def built_meanwhile(*given: Any, **settings: Any) -> VoronoiGraph:
        monkeypatch.setattr(far_planning, "voronoi_graph", build)
        meanwhile.append(finish(planner.routing(START, GOAL, None, NOTHING)))
        return build(*given, **settings)

    monkeypatch.setattr(far_planning, "voronoi_graph", built_meanwhile)
    found = finish(planner.routing(START, GOAL, None, NOTHING))
    assert found is not None
    assert meanwhile[0] is not None
    assert np.array_equal(meanwhile[0], found)


def test_gap_that_was_sensed_closed_is_avoided_by_another_gap() -> None:
    grid = hall((4.0, 1.6), (16.0, 1.6))
    closed = np.column_stack([np.full(30, 15.0), np.linspace(15.0, 17.0, 30)])
    usual = look(grid).points
    at_wall = usual[np.argmin(np.abs(usual[:, 0] - 15.0)), 1]
    closed[:, 1] += at_wall - 16.0
    start = Pose2(12.0, float(at_wall), 0.0)
    ahead = usual[usual[:, 0] > 12.0]
    found = look(grid, start, closed, ahead)
    assert found.kind == "new"
    across = found.points[np.abs(found.points[:, 0] - 15.0) < 0.2, 1]
    assert np.abs(across - at_wall).min() > 5.0
    assert room_along(grid.with_points(closed), found.points) > RADIUS


def test_route_along_the_map_s_border_avoids_what_is_sensed() -> None:
    grid, start = hall((16.0, 1.6)), Pose2(4.0, 1.2, 0.0)
    beside = np.column_stack([np.arange(4.0, 13.0, 0.2), np.full(45, 1.2)])
    route = np.vstack([beside, look(grid, Pose2(13.0, 1.2, 0.0)).points])
    box = np.column_stack([np.full(7, 5.5), np.linspace(0.9, 1.5, 7)])
    found = look(grid, start, box, route)
    assert found.kind == "new"
    assert room_along(grid.with_points(box), found.points) > RADIUS
