import numpy as np
import pytest

from robotics.geometry.pose2 import Pose2
from robotics.navigation.grid_map import GridMap, from_boxes
from robotics.navigation.route import Route, plan_route
from robotics.navigation.shortest_path import shortest_path
from robotics.navigation.voronoi_graph import VoronoiGraph, voronoi_graph


def assert_drivable(graph: VoronoiGraph, route: Route) -> None:
    """No point of the route, nor between its points, comes nearer to obstacles than half a cell allows."""
    dense = np.concatenate(
        [np.linspace(a, b, 4) for a, b in zip(route.points[1:-2], route.points[2:-1], strict=True)]
    )
    rows, columns = graph.map.to_cell(dense).T
    assert graph.clearance[rows, columns].min() > graph.radius - 1.5 * graph.map.resolution
    assert len(route.clearance) == len(route.points)


def random_cells(graph: VoronoiGraph, count: int, seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    rng, cells, pairs = np.random.default_rng(seed), np.argwhere(graph.free), []
    while len(pairs) < count:
        start, goal = cells[rng.integers(len(cells), size=2)]
        if np.hypot(*(goal - start)) * graph.map.resolution > 2.0:
            pairs.append((start, goal))
    return pairs


def centre(graph: VoronoiGraph, cell: np.ndarray) -> tuple[float, float]:
    x, y = graph.map.to_point(cell[None])[0]
    return float(x), float(y)


@pytest.mark.parametrize(
    ("name", "radius", "gain"), [("library", 0.25, 1.25), ("turtlebot3", 0.105, 1.4), ("depot", 0.25, 1.45)]
)
def test_routes_are_short_and_keep_away(name, radius, gain, request):
    graph = voronoi_graph(request.getfixturevalue(name), radius)
    lengths, rooms = [], []
    for start, goal in random_cells(graph, 100, 1):
        route = plan_route(graph, centre(graph, start), centre(graph, goal))
        corners = shortest_path(graph.free, start, goal)
        assert route is not None and corners is not None
        assert_drivable(graph, route)
        steps = np.hypot(*np.diff(corners, axis=0).T)
        along = np.linspace(0.0, steps.sum(), int(steps.sum()) + 2)
        at = np.concatenate([[0.0], np.cumsum(steps)])
        cells = np.column_stack([np.interp(along, at, corners[:, i]) + 0.5 for i in (0, 1)]).astype(int)
        lengths.append(route.length / (steps.sum() * graph.map.resolution))
        rooms.append(route.mean_clearance / graph.clearance[cells[:, 0], cells[:, 1]].mean())
    assert np.mean(lengths) <= 1.15
    assert np.mean(rooms) >= gain


def test_a_route_begins_at_the_start_and_ends_at_the_goal(depot):
    graph = voronoi_graph(depot, 0.25)
    route = plan_route(graph, Pose2(3.011, 4.022, 1.0), (25.033, 12.044))
    assert route is not None
    assert route.points[0].tolist() == [3.011, 4.022]
    assert route.points[-1].tolist() == [25.033, 12.044]
    steps = np.hypot(*np.diff(route.points, axis=0).T)
    assert steps.max() < 0.08


def test_routes_are_smooth(depot):
    """Away from its ends no route turns by more than 30 degrees within 0.2 m."""
    graph = voronoi_graph(depot, 0.25)
    for start, goal in random_cells(graph, 30, 5):
        route = plan_route(graph, centre(graph, start), centre(graph, goal))
        assert route is not None
        rays = route.points[8:-4] - route.points[4:-8]
        heading = np.unwrap(np.arctan2(rays[:, 1], rays[:, 0]))
        turns = np.abs(heading[4:] - heading[:-4])
        assert np.quantile(turns, 0.99, method="lower") < np.radians(60) if len(turns) else True


def test_a_start_pushed_into_the_grown_obstacles_still_works(library):
    graph = voronoi_graph(library, 0.34)
    shelf_side = 1.93 + 0.26
    route = plan_route(graph, (shelf_side + 0.30, 6.0), (shelf_side + 0.28, 5.0))
    assert route is not None
    assert route.length < 1.6


def test_a_start_beyond_reach_gives_none(library):
    graph = voronoi_graph(library, 0.34)
    assert plan_route(graph, (1.93, 6.0), (6.0, 3.0), reach=0.2) is None
    assert plan_route(graph, (6.0, 3.0), (-40.0, 3.0)) is None


def two_rooms(door: float) -> GridMap:
    wall = (3.0 - door) / 2
    boxes = [(3.0, wall / 2, 0.0, 0.1, wall), (3.0, 3.0 - wall / 2, 0.0, 0.1, wall)]
    return from_boxes(boxes, 0.05, (0.0, 0.0), (6.0, 3.0))


def test_without_a_way_there_is_no_route():
    graph = voronoi_graph(two_rooms(0.4), 0.34)
    assert plan_route(graph, (1.0, 1.5), (5.0, 1.5)) is None


def test_through_a_door_the_middle_is_taken():
    graph = voronoi_graph(two_rooms(1.2), 0.34)
    route = plan_route(graph, (1.0, 0.6), (5.0, 0.6))
    assert route is not None
    at_door = route.points[np.argmin(np.abs(route.points[:, 0] - 3.0))]
    assert abs(at_door[1] - 1.5) < 0.15


def test_an_obstacle_that_was_sensed_is_gone_around(library):
    first = plan_route(voronoi_graph(library, 0.34), (1.0, 3.6), (11.0, 7.9))
    assert first is not None
    middle = first.points[len(first.points) // 2]
    seen = library.with_points(middle + np.array([[0.0, 0.0], [0.05, 0.1], [-0.05, 0.1]]), 0.1)
    graph = voronoi_graph(seen, 0.34)
    second = plan_route(graph, (1.0, 3.6), (11.0, 7.9))
    assert second is not None
    assert np.hypot(*(second.points - middle).T).min() > 0.34
    assert_drivable(graph, second)


def test_a_place_out_of_sight_of_the_graph_is_reached():
    """A narrow blind alley with a bend: its edge touches obstacles all along and was pruned."""
    occupied = np.ones((80, 80), dtype=bool)
    occupied[5:40, 5:75] = False
    occupied[40:60, 10:15] = False
    occupied[55:60, 10:50] = False
    graph = voronoi_graph(GridMap(occupied, np.zeros_like(occupied), 0.05, 0.0, 0.0), 0.1)
    route = plan_route(graph, (2.4, 2.875), (3.0, 1.0))
    assert route is not None
    assert_drivable(graph, route)


def test_start_and_goal_in_one_bare_room():
    graph = voronoi_graph(from_boxes([], 0.05, (0.0, 0.0), (2.0, 2.0)), 0.2)
    route = plan_route(graph, (0.5, 0.5), (1.5, 0.6))
    assert route is not None
    assert route.length < 1.4


def test_start_at_the_goal(library):
    route = plan_route(voronoi_graph(library, 0.34), (6.0, 3.0), (6.0, 3.0))
    assert route is not None
    assert route.length < 0.15


def test_the_same_query_gives_the_same_route(depot):
    one, two = (plan_route(voronoi_graph(depot, 0.25), (3.0, 4.0), (25.0, 12.0)) for _ in range(2))
    assert one is not None and two is not None
    assert np.array_equal(one.points, two.points)
