"""Routes through the middle of the free space."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotics.geometry.pose2 import Pose2
from robotics.navigation.blocked_squares import is_clear, line_clearance, path_clearance
from robotics.navigation.graph_search import cheapest_nodes, in_sight, way_in
from robotics.navigation.line_price import line_price
from robotics.navigation.shortcuts import around_corners, rounded, shortcuts
from robotics.navigation.shortest_path import shortest_clear_path
from robotics.navigation.voronoi_graph import BREAK, VoronoiGraph

SAMPLE = 4.0  # of the path, in [cells], before shortcuts
LONGEST_LEAP = 50  # samples
ROUNDS = 20  # of corner rounding: about half a metre of corner on cells of 5 cm


class Route(NamedTuple):
    """A way to drive, from where the robot is to where it is to be."""

    points: NDArray[np.float64]
    """(n, 2) in [m], evenly spaced by about a cell; the first is the start, the last the goal."""
    clearance: NDArray[np.float64]
    """(n,) least distance to any blocked cell's square along the stretches that meet at each point, in [m].

    No spot between two points is nearer than the less of theirs. All of it is at least the graph's radius,
    but for the way out of where the start itself has less room, and the way in to such a goal: never nearer
    there than start or goal itself where that is possible."""

    @property
    def length(self) -> float:
        """In [m]."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def mean_clearance(self) -> float:
        """Over the length, in [m]."""
        return float(self.clearance.mean())


class _End(NamedTuple):
    """How a start or goal joins the graph; all positions are row and column."""

    spot: NDArray[np.float64]
    """The start or goal itself, in [cells]."""
    roomy: bool
    """Whether the way from there to `cell` has the room that the robot needs."""
    cell: NDArray[np.int64]
    joins: NDArray[np.int64]
    """(k,) indices into the edge table's cells."""
    ways: list[NDArray[np.int64]]
    """Cells (2+, 2) from `cell` to each join, in straight lines with room."""
    costs: NDArray[np.float64]
    """(k,) price of each way."""


def plan_route(
    graph: VoronoiGraph,
    start: Pose2 | tuple[float, float],
    goal: Pose2 | tuple[float, float],
    reach: float = 0.3,
    least: float = 0.0,
) -> Route | None:
    """A short way that keeps away from obstacles.

    Start and goal join the graph where they see it (or by a shortest path where they don't), Dijkstra finds
    the way between, shortcuts straighten it and its corners are rounded. Every line is followed from cell to
    cell and its distance to blocked squares is exact, so what the route says of its clearance holds.

    Args:
        graph: of the map and the robot.
        start: only x and y count, in [m].
        goal: only x and y count, in [m].
        reach: how far outside the graph's free component start and goal may be, in [m], rounded up to whole
            cells: localisation noise, a place close to furniture.
        least: clearance without which a route is refused, in [m]: the footprint's radius, say, where the
            graph was grown by more.

    Returns:
        None if start or goal is farther than `reach` from the free component or cut off from it, if they are
        cut off from each other, or if the way needs less clearance than `least`.
    """
    ends = [_join(graph, (point[0], point[1]), reach) for point in (start, goal)]
    if ends[0] is None or ends[1] is None:
        return None
    way = _through_graph(graph, ends[0], ends[1])
    if way is None:
        return None
    points = _with_ends(ends[0], _straightened(graph, _roomy_part(graph, ends[0], way, ends[1])), ends[1])
    clearance = path_clearance(graph.squares, points) * graph.map.resolution
    if clearance.min() < least:
        return None
    return Route(graph.map.to_point(points), clearance)


def _roomy_part(graph: VoronoiGraph, start: _End, way: NDArray[np.int64], goal: _End) -> NDArray[np.float64]:
    """The way (n, 2) around corners that are too narrow, with start and goal where these have room."""
    parts = [around_corners(graph.free, graph.squares, graph.need, way)]
    parts = [start.spot[None], *parts] if start.roomy else parts
    parts = [*parts, goal.spot[None]] if goal.roomy else parts
    path = np.vstack(parts)
    return path[np.concatenate([[True], np.any(np.diff(path, axis=0) != 0.0, axis=1)])]


def _straightened(graph: VoronoiGraph, path: NDArray[np.float64]) -> NDArray[np.float64]:
    """A path (n, 2) in [cells] in straight leaps with round corners, a point about every cell."""
    fine = _sampled(path, SAMPLE)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(fine, axis=0).T))])
    count = max(1, round(float(along[-1]) / SAMPLE))
    samples = np.unique(np.searchsorted(along, np.linspace(0.0, along[-1], count + 1)))
    kept = shortcuts(graph.price, graph.squares, graph.need, fine, samples, LONGEST_LEAP)
    return rounded(graph.squares, graph.need, _sampled(fine[kept], 1.0), ROUNDS)


def _with_ends(start: _End, path: NDArray[np.float64], goal: _End) -> NDArray[np.float64]:
    """The path (n, 2) from start to goal, those included: at least two points."""
    first = path if start.roomy else np.vstack([_sampled(np.array([start.spot, path[0]]), 1.0)[:-1], path])
    whole = first if goal.roomy else np.vstack([first, _sampled(np.array([path[-1], goal.spot]), 1.0)[1:]])
    return whole if len(whole) > 1 else np.vstack([start.spot, goal.spot])


def _join(graph: VoronoiGraph, point: tuple[float, float], reach: float) -> _End | None:
    squares, need, table = graph.squares, graph.need, graph.edges
    x, y = point
    resolution = graph.map.resolution
    spot = np.array([y - graph.map.origin_y, x - graph.map.origin_x]) / resolution - 0.5
    if not np.all((spot >= -0.5) & (spot < np.array(graph.free.shape) - 0.5)):
        return None
    here = line_clearance(squares, spot, spot, need, 0.0)
    if here <= 0.0:
        return None
    found = way_in(graph.free, squares, spot, math.ceil(reach / resolution), here * (1.0 - 1e-9))
    if found[0] < 0:
        return None
    cell = np.array(found)
    roomy = is_clear(squares, spot, cell.astype(np.float64), need)
    joins = in_sight(squares, need, table.cells, table.edge_of, found)
    ways = [np.array([cell, table.cells[i]]) for i in joins]
    if len(joins) == 0 and len(table.cells):
        nearest = np.argmin(((table.cells - cell) ** 2).sum(axis=1))
        way = shortest_clear_path(graph.free, squares, need, cell, table.cells[nearest])
        joins, ways = (joins, []) if way is None else (np.array([nearest]), [way])
    return _End(spot, roomy, cell, joins, ways, np.array([_price(graph, way) for way in ways]))


def _price(graph: VoronoiGraph, way: NDArray[np.int64]) -> float:
    """Price of straight lines between cells (k, 2)."""
    return sum(line_price(graph.price, a, b, np.inf) for a, b in pairwise(way.astype(np.float64)))


def _through_graph(graph: VoronoiGraph, start: _End, goal: _End) -> NDArray[np.int64] | None:
    """Cells (n, 2) of the way from start to goal, cheapest along the graph.

    Where the graph has none (it lies behind a corner that is too narrow), a shortest path on all free cells.
    """
    table = graph.edges
    direct, a, b = _on_one_edge(graph, start, goal)
    start_cost, start_by = _node_costs(graph, start)
    goal_cost, goal_by = _node_costs(graph, goal)
    last, total, back = cheapest_nodes(
        table.slots, table.slot_first, table.ends, table.price, start_cost, goal_cost, direct
    )
    if not min(direct, total) < BREAK:
        return shortest_clear_path(graph.free, graph.squares, graph.need, start.cell, goal.cell)
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


def _sampled(path: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """The path (n, 2) with points between its own, so that none is farther than `spacing` from the next."""
    steps = np.diff(path, axis=0)
    counts = np.maximum(np.ceil(np.hypot(*steps.T) / spacing), 1.0).astype(np.int64)
    of = np.repeat(np.arange(len(steps)), counts)
    share = (np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[of]
    return np.vstack([path[of] + share[:, None] * steps[of], path[-1:]])
