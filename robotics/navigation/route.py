"""Routes through the middle of the free space."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotics.geometry.pose2 import Pose2
from robotics.navigation.graph_search import cheapest_nodes, in_sight, nearest_free
from robotics.navigation.line_of_sight import line_price
from robotics.navigation.shortcuts import rounded, shortcuts
from robotics.navigation.shortest_path import shortest_path
from robotics.navigation.voronoi_graph import VoronoiGraph

SAMPLE = 4.0  # of the path, in [cells], before shortcuts
LONGEST_LEAP = 50  # samples
ROUNDS = 20  # of corner rounding: about half a metre of corner on cells of 5 cm


class Route(NamedTuple):
    """A way to drive, from where the robot is to where it is to be."""

    points: NDArray[np.float64]
    """(n, 2) in [m], evenly spaced by about a cell; the first is the start, the last the goal."""
    clearance: NDArray[np.float64]
    """(n,) distance to the nearest obstacle at each point, in [m]."""

    @property
    def length(self) -> float:
        """In [m]."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def mean_clearance(self) -> float:
        """Over the length, in [m]."""
        return float(self.clearance.mean())


class _End(NamedTuple):
    """How a start or goal joins the graph."""

    cell: NDArray[np.int64]
    joins: NDArray[np.int64]
    """(k,) indices into the edge table's cells."""
    ways: list[NDArray[np.int64]]
    """Cells (2+, 2) from `cell` to each join."""
    costs: NDArray[np.float64]
    """(k,) price of each way."""


def plan_route(
    graph: VoronoiGraph,
    start: Pose2 | tuple[float, float],
    goal: Pose2 | tuple[float, float],
    reach: float = 0.3,
) -> Route | None:
    """A short way that keeps away from obstacles.

    Start and goal join the graph where they see it (or by a shortest path where they don't), Dijkstra finds
    the way between, shortcuts straighten it and its corners are rounded.

    Args:
        graph: of the map and the robot.
        start: only x and y count, in [m].
        goal: only x and y count, in [m].
        reach: how far outside the graph's free component start and goal may be, in [m]: localisation noise, a
            place close to furniture.

    Returns:
        None if start or goal is farther than `reach` from the free component.
    """
    ends = [_join(graph, (point[0], point[1]), reach) for point in (start, goal)]
    if ends[0] is None or ends[1] is None:
        return None
    path = _sample(_through_graph(graph, ends[0], ends[1]).astype(np.float64), SAMPLE)
    cells_clear, free = graph.clearance, graph.free
    corners = path[shortcuts(graph.price, free, path, LONGEST_LEAP)]
    smooth = rounded(cells_clear, free, _sample(corners, 1.0), ROUNDS)
    clearance = cells_clear[tuple((smooth + 0.5).astype(np.int64).T)].astype(np.float64)
    return _with_ends(graph, smooth, clearance, start, goal)


def _with_ends(
    graph: VoronoiGraph,
    path: NDArray[np.float64],
    clearance: NDArray[np.float64],
    start: Pose2 | tuple[float, float],
    goal: Pose2 | tuple[float, float],
) -> Route:
    """The exact start and goal in place of those positions (n, 2), in [cells], within a cell of them."""
    points = graph.map.to_point(path)
    ends = np.array([start[:2], goal[:2]])
    far = [np.hypot(*(points - end).T) > graph.map.resolution for end in ends]
    kept = far[0] & far[1]
    around = np.concatenate([clearance[:1], clearance[kept], clearance[-1:]])
    return Route(np.vstack([ends[:1], points[kept], ends[1:]]), around)


def _join(graph: VoronoiGraph, point: tuple[float, float], reach: float) -> _End | None:
    row, column = graph.map.to_cell(np.array([point]))[0].tolist()
    found = nearest_free(graph.free, row, column, math.ceil(reach / graph.map.resolution))
    if found[0] < 0:
        return None
    cell, table = np.array(found), graph.edges
    if len(table.cells) == 0:
        return _End(cell, np.empty(0, dtype=np.int64), [], np.empty(0))
    joins = in_sight(graph.free, table.cells, table.edge_of, found)
    ways = [np.array([cell, table.cells[i]]) for i in joins]
    if len(joins) == 0:
        nearest = np.argmin(((table.cells - cell) ** 2).sum(axis=1))
        way = shortest_path(graph.free, cell, table.cells[nearest])
        joins, ways = np.array([nearest]), [] if way is None else [way]
    return _End(cell, joins, ways, np.array([_price(graph, way) for way in ways]))


def _price(graph: VoronoiGraph, way: NDArray[np.int64]) -> float:
    """Price of straight lines between cells (k, 2)."""
    corners = way.astype(np.float64)
    return sum(line_price(graph.price, graph.free, a, b, np.inf) for a, b in pairwise(corners))


def _through_graph(graph: VoronoiGraph, start: _End, goal: _End) -> NDArray[np.int64]:
    """Cells (n, 2) of the way from start to goal, shortest along the graph."""
    if len(start.joins) == 0:
        way = shortest_path(graph.free, start.cell, goal.cell)
        assert way is not None, "both are cells of one component"
        return way
    table = graph.edges
    direct, a, b = _on_one_edge(graph, start, goal)
    start_cost, start_by = _node_costs(graph, start)
    goal_cost, goal_by = _node_costs(graph, goal)
    last, _, back = cheapest_nodes(
        table.slots, table.slot_first, table.ends, table.price, start_cost, goal_cost, direct
    )
    if last < 0:
        return np.vstack([start.ways[a], _stretch(graph, start.joins[a], goal.joins[b]), goal.ways[b][::-1]])
    parts = [goal.ways[goal_by[last]][::-1], _to_node(graph, goal.joins[goal_by[last]], last)[::-1]]
    node = last
    while back[node] >= 0:
        edge, end = divmod(int(back[node]), 2)
        run = table.cells[table.first[edge] : table.first[edge + 1]]
        parts.append(run if end == 1 else run[::-1])
        node = table.ends[edge, 1 - end]
    parts += [_to_node(graph, start.joins[start_by[node]], node), start.ways[start_by[node]]]
    return np.vstack(parts[::-1])


def _node_costs(graph: VoronoiGraph, end: _End) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """For each node the length from `end` to it along a joined edge, inf where none, and by which join."""
    table = graph.edges
    cost = np.full(len(table.nodes), np.inf)
    by = np.zeros(len(table.nodes), dtype=np.int64)
    for k, join in enumerate(end.joins.tolist()):
        edge, along = table.edge_of[join], table.price_along[join]
        for node, rest in zip(table.ends[edge], (along, table.price[edge] - along), strict=True):
            if end.costs[k] + rest < cost[node]:
                cost[node], by[node] = end.costs[k] + rest, k
    return cost, by


def _on_one_edge(graph: VoronoiGraph, start: _End, goal: _End) -> tuple[float, int, int]:
    """The shortest way that leaves an edge before reaching a node: length and which joins; inf if none."""
    table = graph.edges
    best = (math.inf, 0, 0)
    for a, i in enumerate(start.joins.tolist()):
        for b, j in enumerate(goal.joins.tolist()):
            if table.edge_of[i] == table.edge_of[j]:
                between = abs(float(table.price_along[i] - table.price_along[j]))
                best = min(best, (float(start.costs[a] + goal.costs[b]) + between, a, b))
    return best


def _stretch(graph: VoronoiGraph, i: int, j: int) -> NDArray[np.int64]:
    """Cells of one edge from its cell i to its cell j."""
    cells = graph.edges.cells
    return cells[i : j + 1] if i <= j else cells[j : i + 1][::-1]


def _to_node(graph: VoronoiGraph, join: int, node: int) -> NDArray[np.int64]:
    """Cells from a join along its edge to one of the edge's nodes, the nearer one if both are the same."""
    table = graph.edges
    edge = table.edge_of[join]
    at_first, at_last = table.ends[edge] == node
    before, after = table.price_along[join], table.price[edge] - table.price_along[join]
    if at_first and (not at_last or before <= after):
        return _stretch(graph, join, int(table.first[edge]))
    return _stretch(graph, join, int(table.first[edge + 1]) - 1)


def _sample(path: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """The path (n, 2), sampled evenly about every `spacing`, both ends kept."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    count = max(1, round(float(along[-1]) / spacing))
    at = np.linspace(0.0, along[-1], count + 1)
    return np.column_stack([np.interp(at, along, path[:, 0]), np.interp(at, along, path[:, 1])])
