from __future__ import annotations

import numpy as np
import pytest
from skimage.graph import MCP_Geometric

from benchmarks.driving.routes import try_grid
from benchmarks.driving.worlds.random_grids import (
    GRID_KINDS,
    distance_to_squares,
    random_grid,
    rooms,
    streets,
)
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.routes.route import Route, plan_route
from handcart.robotics.navigation.routes.shortest_path import shortest_path
from handcart.robotics.navigation.routes.voronoi_graph import VoronoiGraph, voronoi_graph


def assert_drivable(graph: VoronoiGraph, route: Route) -> None:
    """The robot's room is kept, and no spot is nearer to what is blocked than the route says."""
    assert route.clearance.min() >= graph.radius * (1.0 - 1e-5)
    assert shortfall(graph.map, route, np.random.default_rng(0), 40) < 1e-9


def shortfall(grid: GridMap, route: Route, rng: np.random.Generator, samples: int) -> float:
    """Return by how much any of some random points of the route is nearer than it claims, in [m]."""
    i, share = rng.integers(len(route.points) - 1, size=samples), rng.random(samples)
    spots = route.points[i] + share[:, None] * (route.points[i + 1] - route.points[i])
    said = route.clearance[i] + share * (route.clearance[i + 1] - route.clearance[i])
    cells = (spots - (grid.origin_x, grid.origin_y))[:, ::-1] / grid.resolution - 0.5
    return float((said - distance_to_squares(grid.blocked, cells) * grid.resolution).max())


def random_cells(graph: VoronoiGraph, count: int, seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    pairs: list[tuple[np.ndarray, np.ndarray]] = []
    rng, cells = np.random.default_rng(seed), np.argwhere(graph.free)
    while len(pairs) < count:
        start, goal = cells[rng.integers(len(cells), size=2)]
        if np.hypot(*(goal - start)) * graph.map.resolution > 2.0:
            pairs.append((start, goal))
    return pairs


def centre(graph: VoronoiGraph, cell: np.ndarray) -> tuple[float, float]:
    x, y = graph.map.to_point(cell[None])[0]
    return float(x), float(y)


@pytest.mark.parametrize(
    ("name", "radius", "gain"), [("library", 0.25, 1.35), ("turtlebot3", 0.105, 1.25), ("depot", 0.25, 1.28)]
)
def test_routes_are_short_and_keep_away(
    name: str, radius: float, gain: float, request: pytest.FixtureRequest
) -> None:
    graph = voronoi_graph(request.getfixturevalue(name), radius)
    lengths, rooms = [], []
    for start, goal in random_cells(graph, 50, 1):
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
    assert np.mean(lengths) <= 1.1
    assert np.mean(rooms) >= gain


def test_a_route_begins_at_the_start_and_ends_at_the_goal(depot: GridMap) -> None:
    graph = voronoi_graph(depot, 0.25)
    route = plan_route(graph, Pose2(3.011, 4.022, 1.0), (25.033, 12.044))
    assert route is not None
    assert route.points[0].tolist() == [3.011, 4.022]
    assert route.points[-1].tolist() == [25.033, 12.044]
    steps = np.hypot(*np.diff(route.points, axis=0).T)
    assert steps.max() < 0.08


def test_routes_are_smooth(depot: GridMap) -> None:
    """Away from its ends no route turns by more than 30 degrees within 0.2 m."""
    graph = voronoi_graph(depot, 0.25)
    for start, goal in random_cells(graph, 30, 5):
        route = plan_route(graph, centre(graph, start), centre(graph, goal))
        assert route is not None
        rays = route.points[8:-4] - route.points[4:-8]
        heading = np.unwrap(np.arctan2(rays[:, 1], rays[:, 0]))
        turns = np.abs(heading[4:] - heading[:-4])
        assert np.quantile(turns, 0.99, method="lower") < np.radians(60) if len(turns) else True


def test_a_start_pushed_into_the_grown_obstacles_still_works(library: GridMap) -> None:
    graph = voronoi_graph(library, 0.34)
    shelf_side = 1.93 + 0.26
    route = plan_route(graph, (shelf_side + 0.30, 6.0), (shelf_side + 0.28, 5.0))
    assert route is not None
    assert route.length < 1.6


def test_a_start_beyond_reach_gives_none(library: GridMap) -> None:
    graph = voronoi_graph(library, 0.34)
    assert plan_route(graph, (1.93, 6.0), (6.0, 3.0), reach=0.2) is None
    assert plan_route(graph, (6.0, 3.0), (-40.0, 3.0)) is None


def two_rooms(door: float) -> GridMap:
    wall = (3.0 - door) / 2
    boxes = [(3.0, wall / 2, 0.0, 0.1, wall), (3.0, 3.0 - wall / 2, 0.0, 0.1, wall)]
    return from_boxes(boxes, 0.05, (0.0, 0.0), (6.0, 3.0))


def test_without_a_way_there_is_no_route() -> None:
    graph = voronoi_graph(two_rooms(0.4), 0.34)
    assert plan_route(graph, (1.0, 1.5), (5.0, 1.5)) is None


def test_through_a_door_the_middle_is_taken() -> None:
    graph = voronoi_graph(two_rooms(1.2), 0.34)
    route = plan_route(graph, (1.0, 0.6), (5.0, 0.6))
    assert route is not None
    at_door = route.points[np.argmin(np.abs(route.points[:, 0] - 3.0))]
    assert abs(at_door[1] - 1.5) < 0.15


def test_an_obstacle_that_was_sensed_is_gone_around(library: GridMap) -> None:
    first = plan_route(voronoi_graph(library, 0.34), (1.0, 3.6), (11.0, 7.9))
    assert first is not None
    middle = first.points[len(first.points) // 2]
    seen = library.with_points(middle + np.array([[0.0, 0.0], [0.05, 0.1], [-0.05, 0.1]]), 0.1)
    graph = voronoi_graph(seen, 0.34)
    second = plan_route(graph, (1.0, 3.6), (11.0, 7.9))
    assert second is not None
    assert np.hypot(*(second.points - middle).T).min() > 0.34
    assert_drivable(graph, second)


def test_a_place_out_of_sight_of_the_graph_is_reached() -> None:
    """A narrow blind alley with a bend: its edge touches obstacles all along and was pruned."""
    occupied = np.ones((80, 80), dtype=bool)
    occupied[5:40, 5:75] = False
    occupied[40:60, 10:15] = False
    occupied[55:60, 10:50] = False
    graph = voronoi_graph(GridMap(occupied, np.zeros_like(occupied), 0.05, 0.0, 0.0), 0.1)
    route = plan_route(graph, (2.4, 2.875), (3.0, 1.0))
    assert route is not None
    assert_drivable(graph, route)


def test_start_and_goal_in_one_bare_room() -> None:
    graph = voronoi_graph(from_boxes([], 0.05, (0.0, 0.0), (2.0, 2.0)), 0.2)
    route = plan_route(graph, (0.5, 0.5), (1.5, 0.6))
    assert route is not None
    assert route.length < 1.4


def test_start_at_the_goal(library: GridMap) -> None:
    route = plan_route(voronoi_graph(library, 0.34), (6.0, 3.0), (6.0, 3.0))
    assert route is not None
    assert route.length < 0.15


def test_the_same_query_gives_the_same_route(depot: GridMap) -> None:
    one, two = (plan_route(voronoi_graph(depot, 0.25), (3.0, 4.0), (25.0, 12.0)) for _ in range(2))
    assert one is not None and two is not None
    assert np.array_equal(one.points, two.points)


@pytest.mark.parametrize("kind", range(len(GRID_KINDS)))
def test_route_clearance_is_true_on_cells_of_any_size(kind: int) -> None:
    """Walls one cell thick, diagonal ones, cells larger than the robot; starts anywhere in their cells."""
    planned = 0
    for seed in range(kind, 25 * len(GRID_KINDS), len(GRID_KINDS)):
        grid, radius = random_grid(seed)
        try:
            graph = voronoi_graph(grid, radius)
        except ValueError:
            continue
        rng, cells = np.random.default_rng(seed), np.argwhere(graph.free)
        for off in (0.0, 0.49):
            ends = grid.to_point(cells[rng.integers(len(cells), size=2)] + rng.uniform(-off, off, (2, 2)))
            route = plan_route(graph, tuple(ends[0]), tuple(ends[1]))
            if route is None:
                continue
            planned += 1
            assert np.allclose(route.points[[0, -1]], ends)
            assert len(route.clearance) == len(route.points)
            assert shortfall(grid, route, rng, 200) < 1e-9
            assert off > 0.0 or route.clearance.min() >= radius * (1.0 - 1e-5)
    assert planned > 20


@pytest.mark.parametrize(("resolution", "radius"), [(0.2, 0.1), (0.2, 0.25), (0.25, 0.25), (0.4, 0.19)])
def test_no_route_cuts_a_wall_one_cell_thick(resolution: float, radius: float) -> None:
    occupied = rooms(np.random.default_rng(1), (45, 45), room=8, door=3)
    graph = voronoi_graph(GridMap(occupied, np.zeros_like(occupied), resolution, -3.0, 2.0), radius)
    for start, goal in random_cells(graph, 30, 2):
        route = plan_route(graph, centre(graph, start), centre(graph, goal))
        assert route is not None
        assert_drivable(graph, route)


def diagonal_wall(size: int) -> GridMap:
    occupied = np.zeros((size, size), dtype=bool)
    occupied[np.arange(size), np.arange(size)] = True
    return GridMap(occupied, np.zeros_like(occupied), 0.2, 0.0, 0.0)


@pytest.mark.parametrize("radius", [0.0, 0.05, 0.1])
def test_nothing_slips_through_a_diagonal_wall(radius: float) -> None:
    graph = voronoi_graph(diagonal_wall(20), radius)
    assert plan_route(graph, (3.5, 0.5), (0.5, 3.5)) is None
    route = plan_route(graph, (3.5, 0.5), (1.1, 0.5))
    assert route is not None
    assert_drivable(graph, route)


def test_a_diagonal_wall_is_gone_around() -> None:
    grid = diagonal_wall(20)
    grid.occupied[19, 19] = False
    graph = voronoi_graph(grid, 0.1)
    route = plan_route(graph, (3.5, 0.5), (0.5, 3.5))
    assert route is not None
    assert_drivable(graph, route)
    assert route.points.max() > 3.75


def test_a_start_beside_a_thin_wall_does_not_leave_through_it() -> None:
    """On its own side nothing is free; on the other, 0.2 m away, all is."""
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[:, 4] = True
    graph = voronoi_graph(GridMap(occupied, np.zeros_like(occupied), 0.05, 0.0, 0.0), 0.15)
    assert not graph.free[:, :4].any()
    assert plan_route(graph, (0.16, 1.5), (2.0, 1.5)) is None


def test_route_out_of_a_narrow_spot_leads_to_room_and_no_nearer(library: GridMap) -> None:
    graph = voronoi_graph(library, 0.34)
    start = (1.93 + 0.26 + 0.24, 6.0)
    route = plan_route(graph, start, (2.9, 4.0))
    assert route is not None
    narrow = route.clearance < 0.34 * (1.0 - 1e-5)
    assert narrow[:2].all() and not narrow[6:].any()
    cells = (np.array([start[::-1]]) - (graph.map.origin_y, graph.map.origin_x)) / 0.05 - 0.5
    assert route.clearance.min() == pytest.approx(0.05 * distance_to_squares(library.blocked, cells)[0])


def test_a_route_into_a_narrow_spot_is_as_evenly_spaced_as_any(library: GridMap) -> None:
    graph = voronoi_graph(library, 0.34)
    route = plan_route(graph, (2.9, 4.0), (1.93 + 0.26 + 0.24, 6.0))
    assert route is not None
    assert route.clearance.min() < 0.34 * (1.0 - 1e-5)
    assert np.hypot(*np.diff(route.points, axis=0).T).min() > 0.01


@pytest.mark.parametrize("goal", [(5.0, 5.0), (5.0, 1.0)])
def test_around_a_block_the_shorter_way_is_taken(goal: tuple[float, float]) -> None:
    """An alley leads to a ring, which is one edge of the graph with both ends at one node."""
    occupied = np.ones((120, 160), dtype=bool)
    occupied[5:115, 45:155] = False
    occupied[35:85, 75:125] = True
    occupied[54:66, 5:45] = False
    graph = voronoi_graph(GridMap(occupied, np.zeros_like(occupied), 0.05, 0.0, 0.0), 0.2)
    route = plan_route(graph, (0.6, 3.0), goal)
    assert route is not None
    assert route.length < 6.0


def test_a_route_with_less_clearance_than_asked_is_refused(library: GridMap) -> None:
    graph = voronoi_graph(library, 0.34)
    start, goal = (1.93 + 0.26 + 0.24, 6.0), (2.9, 4.0)
    route = plan_route(graph, start, goal)
    assert route is not None
    least = float(route.clearance.min())
    assert plan_route(graph, start, goal, least=least - 1e-6) is not None
    assert plan_route(graph, start, goal, least=least + 1e-6) is None


def test_a_start_in_a_blocked_cell_or_off_the_map_has_no_route(library: GridMap) -> None:
    graph = voronoi_graph(library, 0.1)
    assert plan_route(graph, (1.93, 6.0), (6.0, 3.0), reach=5.0) is None
    assert plan_route(graph, (-0.1, 3.0), (6.0, 3.0), reach=5.0) is None


def grid_optimum(graph: VoronoiGraph, start: np.ndarray, goal: np.ndarray) -> float:
    """Length of the shortest 8-connected path over free cells, in [m]."""
    search = MCP_Geometric(np.where(graph.free, 1.0, -1.0))
    costs, _ = search.find_costs([tuple(start)], [tuple(goal)])
    return float(costs[tuple(goal)]) * graph.map.resolution


@pytest.mark.parametrize("made", ["streets", "rooms"])
@pytest.mark.parametrize("radius", [0.0, 0.5])
def test_routes_are_hardly_longer_than_the_grids_optimum(made: str, radius: float) -> None:
    rng = np.random.default_rng(3)
    occupied = streets(rng, (128, 128)) if made == "streets" else rooms(rng, (128, 128), room=16)
    graph = voronoi_graph(GridMap(occupied, np.zeros_like(occupied), 1.0, 0.0, 0.0), radius)
    ratios = []
    for start, goal in random_cells(graph, 60, 4):
        route = plan_route(graph, centre(graph, start), centre(graph, goal))
        assert route is not None
        ratios.append(route.length / grid_optimum(graph, start, goal))
    assert np.median(ratios) <= 1.07
    assert np.quantile(ratios, 0.95) <= 1.25


def test_where_more_room_costs_little_it_is_taken() -> None:
    """Down a hall, with furniture along one side."""
    boxes = [(2.0 + 2.0 * k, 0.5, 0.0, 0.8, 1.0) for k in range(8)]
    graph = voronoi_graph(from_boxes(boxes, 0.05, (0.0, 0.0), (18.0, 4.0)), 0.3)
    route = plan_route(graph, (0.6, 1.4), (17.4, 1.4))
    assert route is not None
    assert route.length < 1.1 * 16.8
    assert np.quantile(route.clearance, 0.25) > 0.9


@pytest.mark.slow
def test_ten_thousand_samples_of_routes_on_random_grids() -> None:
    """As the benchmark does a million: nothing nearer than said, no room given away, no way missed."""
    samples = 0
    for seed in range(1000, 1012):
        found = try_grid(seed)
        samples += found.samples
        assert (found.nearer, found.tight, found.missing) == (0, 0, 0)
    assert samples > 10_000
