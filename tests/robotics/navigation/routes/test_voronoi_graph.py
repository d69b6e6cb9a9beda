from __future__ import annotations

from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray
from scipy import ndimage

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.thinning import thin
from handcart.robotics.navigation.routes.voronoi_graph import VoronoiGraph, voronoi_graph


def topology(free: np.ndarray) -> tuple[int, int]:
    """Components (8-connected) and holes (4-connected) of the free cells, counted by scipy."""
    padded = np.pad(free, 1)
    return ndimage.label(padded, np.ones((3, 3)))[1], ndimage.label(~padded)[1] - 1


def grid_of(occupied: np.ndarray, resolution: float = 0.05) -> GridMap:
    return GridMap(occupied, np.zeros_like(occupied), resolution, 0.0, 0.0)


def assert_sound(graph: VoronoiGraph) -> None:
    assert (graph.components, graph.cycles) == topology(graph.free)
    for a, b, edge in graph.graph.edges(data=True):
        points = edge["points"]
        ends = {tuple(graph.graph.nodes[n]["point"]) for n in (a, b)}
        assert {tuple(points[0].tolist()), tuple(points[-1].tolist())} == ends
        steps = np.hypot(*np.diff(points, axis=0).T)
        assert steps.max() < 1.5 * graph.map.resolution
        assert steps.sum() == pytest.approx(edge["length"])
        cells = graph.map.to_cell(points)
        assert graph.free[cells[:, 0], cells[:, 1]].all()


def test_depot_has_33_cycles(depot: GridMap) -> None:
    graph = voronoi_graph(depot, 0.25)
    assert (graph.components, graph.cycles) == (1, 33)


@pytest.mark.parametrize("radius", [0.0, 0.1, 0.22, 0.34, 0.5])
@pytest.mark.parametrize("name", ["depot", "turtlebot3", "library"])
def test_topology_is_exact_on_real_maps(name: str, radius: float, request: pytest.FixtureRequest) -> None:
    assert_sound(voronoi_graph(request.getfixturevalue(name), radius))


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.02, 0.1, 0.3, 0.5])
def test_topology_is_exact_on_random_maps(share: float) -> None:
    rng = np.random.default_rng(int(1000 * share))
    for _ in range(75):
        occupied = rng.random(rng.integers(4, 70, 2)) < share
        radius = float(rng.choice([0.0, 0.05, 0.1]))
        try:
            graph = voronoi_graph(grid_of(occupied), radius)
        except ValueError:
            continue
        assert_sound(graph)


@settings(deadline=None, max_examples=150)
@given(hnp.arrays(bool, st.tuples(st.integers(1, 9), st.integers(1, 9))))
def test_topology_is_exact_on_the_nastiest_small_maps(occupied: NDArray[Any]) -> None:
    try:
        graph = voronoi_graph(grid_of(occupied), 0.0)
    except ValueError:
        assert occupied.all()
        return
    assert_sound(graph)


def test_a_skeleton_has_the_topology_of_what_was_thinned(library: GridMap) -> None:
    free = np.pad(~library.blocked, 1)
    distance = ndimage.distance_transform_edt(free).astype(np.float32)
    assert topology(thin(free, distance)) == topology(free)


def test_a_corridors_graph_runs_in_its_middle() -> None:
    occupied = np.zeros((21, 200), dtype=bool)
    graph = voronoi_graph(grid_of(occupied), 0.1)
    (edge,) = [edge["points"] for _, _, edge in graph.graph.edges(data=True)]
    assert np.abs(edge[:, 1] - 21 * 0.05 / 2).max() <= 0.05
    assert np.ptp(edge[:, 0]) > 8.5


def test_the_graph_is_centred_on_a_real_map(depot: GridMap) -> None:
    """No step sideways of two cells leads to more room."""
    graph = voronoi_graph(depot, 0.25)
    best = ndimage.maximum_filter(graph.clearance, footprint=np.ones((3, 3)))
    middle = np.concatenate([edge["points"][8:-8] for _, _, edge in graph.graph.edges(data=True)])
    rows, columns = graph.map.to_cell(middle).T
    lost = best[rows, columns] - graph.clearance[rows, columns]
    assert np.quantile(lost, 0.99) <= 1.5 * 0.05


def test_edge_into_a_dead_end_is_kept_and_corner_spurs_are_not() -> None:
    occupied = np.zeros((60, 120), dtype=bool)
    occupied[:, 58:62] = True
    occupied[25:35, 58:62] = False
    graph = voronoi_graph(grid_of(occupied), 0.1)
    assert graph.cycles == 0
    points = np.array([point for _, point in graph.graph.nodes(data="point")])
    assert points[:, 0].min() < 2.0 and points[:, 0].max() > 4.0
    edges = [edge for _, _, edge in graph.graph.edges(data=True)]
    assert min(edge["clearance"] for edge in edges) > 0.1 + 2 * 0.05


def test_unknown_cells_are_obstacles() -> None:
    occupied = np.zeros((40, 40), dtype=bool)
    unknown = occupied.copy()
    unknown[18:22, 18:22] = True
    assert voronoi_graph(GridMap(occupied, unknown, 0.05, 0.0, 0.0), 0.1).cycles == 1


def test_the_component_is_the_seeds_or_else_the_largest() -> None:
    occupied = np.zeros((30, 90), dtype=bool)
    occupied[:, 29] = True
    grid = grid_of(occupied)
    largest, seeded = voronoi_graph(grid, 0.1), voronoi_graph(grid, 0.1, (0.5, 0.7))
    assert largest.free[:, 30:].any() and not largest.free[:, :29].any()
    assert seeded.free[:, :29].any() and not seeded.free[:, 30:].any()
    assert np.array_equal(voronoi_graph(grid, 0.1, (1.43, 0.7)).free, seeded.free)


def test_no_room_at_all_is_an_error() -> None:
    with pytest.raises(ValueError, match="no free cell"):
        voronoi_graph(grid_of(np.zeros((8, 8), dtype=bool)), 1.0)


def test_a_plain_loop_and_parallel_edges_are_kept() -> None:
    occupied = np.zeros((40, 80), dtype=bool)
    occupied[15:25, 15:65] = True
    assert voronoi_graph(grid_of(occupied), 0.1).cycles == 1
    occupied[15:25, 36:44] = False
    graph = voronoi_graph(grid_of(occupied), 0.1)
    assert graph.cycles == 2
    assert any(graph.graph.number_of_edges(a, b) > 1 for a, b in graph.graph.edges())


def test_the_graph_is_the_same_each_time(depot: GridMap) -> None:
    one, two = (voronoi_graph(depot, 0.25) for _ in range(2))
    assert nx.utils.graphs_equal(
        nx.MultiGraph((a, b, k) for a, b, k in one.graph.edges(keys=True)),
        nx.MultiGraph((a, b, k) for a, b, k in two.graph.edges(keys=True)),
    )
    assert np.array_equal(one.edges.cells, two.edges.cells)
