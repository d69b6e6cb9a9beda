"""Routes through the middle of the free space."""

from __future__ import annotations

import math
from collections.abc import Generator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.blocked_squares import is_clear, line_clearance, path_clearance
from handcart.robotics.navigation.routes.graph_search import cheapest_nodes, in_sight, way_in
from handcart.robotics.navigation.routes.line_price import line_price
from handcart.robotics.navigation.routes.shortcuts import (
    around_corners,
    path_length,
    rounded,
    sampled,
    straightened,
)
from handcart.robotics.navigation.routes.shortest_path import shortest_clear_path
from handcart.robotics.navigation.routes.voronoi_graph import BLOCKED_PRICE, STEP_CELLS, VoronoiGraph
from handcart.robotics.numerics.arrays import FloatArray, IntArray
from handcart.robotics.numerics.stepwise import finish

MAX_DETOUR_RATIO = 1.1  # of the shortest way's length, that a way with more room may have
LENGTH_PRICE_SHARES = (
    0.05,
    0.15,
    0.4,
)  # of the dearest cell's price, that length costs by itself while a way is too long
SHORTEST_LENGTH_PRICE = 1e4  # that length costs by itself where nothing else counts
LONG_CORNER_ROOM_M = 0.12  # beside the graph's radius, that longer corners than usual do not give away
CORNER_ROUNDING_PASSES = 20  # of corner rounding: about half a metre of corner on cells of 5 cm


class Route(NamedTuple):
    """Planned route of the base from its position to a goal, as points on the map with their clearances."""

    points: FloatArray
    """Points (n, 2) in [m], evenly spaced by roughly a cell; the first is the start, the last the goal."""
    clearance: FloatArray
    """(n,) least distance to any blocked cell's square along the stretches that meet at each point, in [m].

    No spot between two points is nearer than the lesser clearance of the two. The clearance is at least the
    graph's radius, except near a start or goal that itself has less room; there it is at least that of the
    start or goal, if possible."""

    @property
    def length(self) -> float:
        """Length of the route, in [m]."""
        return path_length(self.points)

    @property
    def mean_clearance(self) -> float:
        """Mean clearance over the length of the route, in [m]."""
        return float(self.clearance.mean())


class _End(NamedTuple):
    """A start or goal and its connections to the graph; all positions are row and column."""

    spot: FloatArray
    """Start or goal itself (2,), row and column in [cells]."""
    roomy: bool
    """True if the line from the spot to `cell` has the room that the robot needs."""
    cell: IntArray
    joins: IntArray
    """(k,) indices into the edge table's cells."""
    ways: list[IntArray]
    """Cells (2+, 2) from `cell` to each join, in straight lines with room."""
    price: FloatArray
    """Price (k,) of each way."""
    length: FloatArray
    """Length (k,) of each way, in [cells]."""


def plan_route(
    graph: VoronoiGraph,
    start: Pose2 | tuple[float, float],
    goal: Pose2 | tuple[float, float],
    reach: float = 0.3,
    least: float = 0.0,
    rounding: float = 1.0,
    passes: int = CORNER_ROUNDING_PASSES,
) -> Route | None:
    """Return a short route through a Voronoi graph, which keeps away from obstacles; None if none exists.

    Args:
        graph: Voronoi graph of the map.
        start: position on the map, in [m]; a heading is ignored.
        goal: position on the map, in [m]; a heading is ignored.
        reach: distance that start and goal may be outside the free space, in [m].
        least: minimum clearance of the route, in [m]; None is returned if the route's clearance is smaller.
        rounding: length over which corners are rounded, as a multiple of the default length; above 1, corners
            become wider arcs where there is room.
        passes: number of passes that round the corners.
    """
    return finish(routing(graph, start, goal, reach, least, rounding, passes))


def routing(
    graph: VoronoiGraph,
    start: Pose2 | tuple[float, float],
    goal: Pose2 | tuple[float, float],
    reach: float = 0.3,
    least: float = 0.0,
    rounding: float = 1.0,
    passes: int = CORNER_ROUNDING_PASSES,
) -> Generator[None, None, Route | None]:
    """Return a short route like `plan_route`; a generator that yields, on a map of more than `STEP_CELLS`,
    before it looks for shorter ways and before it rounds the corners.

    Args:
        graph: Voronoi graph of the map.
        start: position on the map, as for `plan_route`.
        goal: position on the map.
        reach: distance that start and goal may be outside the free space, in [m].
        least: minimum clearance of the route, in [m].
        rounding: length over which corners are rounded.
        passes: number of passes that round the corners.
    """
    ends = [_join(graph, (point[0], point[1]), reach) for point in (start, goal)]
    if ends[0] is None or ends[1] is None:
        return None
    path = yield from _within_reason(graph, ends[0], ends[1])
    if path is None:
        return None
    if graph.free.size > STEP_CELLS:
        yield
    squares, need = graph.squares, graph.need
    if rounding > 1.0:  # passes over fewer points round longer corners
        roomy = need + LONG_CORNER_ROOM_M / graph.map.resolution
        path = rounded(squares, need, sampled(path, rounding), passes, roomy)
    smooth = rounded(squares, need, sampled(path, 1.0), passes, 0.0)
    points = _with_ends(ends[0], smooth, ends[1])
    clearance = path_clearance(graph.squares, points) * graph.map.resolution
    if clearance.min() < least:
        return None
    return Route(graph.map.to_point(points), clearance)


def _within_reason(graph: VoronoiGraph, start: _End, goal: _End) -> Generator[None, None, FloatArray | None]:
    """Return the way with the most room that isn't much longer than the shortest; (n, 2), in [cells]."""
    points = _way(graph, start, goal, 0.0)
    if points is None or path_length(points) <= MAX_DETOUR_RATIO * math.hypot(*(points[-1] - points[0])):
        return points
    if graph.free.size > STEP_CELLS:
        yield
    shortest = _way(graph, start, goal, SHORTEST_LENGTH_PRICE)
    assert shortest is not None, "where one way leads, the shortest does"
    for share in LENGTH_PRICE_SHARES:
        if path_length(points) <= MAX_DETOUR_RATIO * path_length(shortest):
            return points
        again = _way(graph, start, goal, share * graph.dearest)
        assert again is not None
        points = again
    return points if path_length(points) <= MAX_DETOUR_RATIO * path_length(shortest) else shortest


def _way(graph: VoronoiGraph, start: _End, goal: _End, haste: float) -> FloatArray | None:
    """Return the cheapest way's roomy part (n, 2), in [cells], where length costs `haste` on top of its
    price.
    """
    way = _through_graph(graph, start, goal, haste)
    if way is None:
        return None
    return straightened(graph.price, haste, graph.squares, graph.need, _roomy_part(graph, start, way, goal))


def _roomy_part(graph: VoronoiGraph, start: _End, way: IntArray, goal: _End) -> FloatArray:
    """Return the way (n, 2) around corners that are too narrow, with start and goal where these have room."""
    parts = [around_corners(graph.free, graph.squares, graph.need, way)]
    parts = [start.spot[None], *parts] if start.roomy else parts
    parts = [*parts, goal.spot[None]] if goal.roomy else parts
    return np.vstack(parts)


def _with_ends(start: _End, path: FloatArray, goal: _End) -> FloatArray:
    """Return the path (n, 2) from start to goal, those included: at least two points."""
    first = path if start.roomy else np.vstack([sampled(np.array([start.spot, path[0]]), 1.0)[:-1], path])
    whole = first if goal.roomy else np.vstack([first, sampled(np.array([path[-1], goal.spot]), 1.0)[1:]])
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
    price = np.array([_price(graph, way) for way in ways])
    return _End(
        spot, roomy, cell, joins, ways, price, np.array([path_length(way.astype(np.float64)) for way in ways])
    )


def _price(graph: VoronoiGraph, way: IntArray) -> float:
    """Price of straight lines between cells (k, 2)."""
    return sum(line_price(graph.price, a, b, np.inf) for a, b in pairwise(way.astype(np.float64)))


def _through_graph(graph: VoronoiGraph, start: _End, goal: _End, haste: float) -> IntArray | None:
    """Return the cells (n, 2) of the cheapest path from start to goal along the graph.

    If the graph has none (it lies behind a corner that is too narrow), return a shortest path on all free
    cells.
    """
    table = graph.edges
    direct, a, b = _on_one_edge(graph, start, goal, haste)
    start_cost, start_by = _node_costs(graph, start, haste)
    goal_cost, goal_by = _node_costs(graph, goal, haste)
    price = table.price + haste * table.length
    last, total, back = cheapest_nodes(
        table.slots, table.slot_first, table.ends, price, start_cost, goal_cost, direct
    )
    if not min(direct, total) < BLOCKED_PRICE:
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


def _node_costs(graph: VoronoiGraph, end: _End, haste: float) -> tuple[FloatArray, IntArray]:
    """Return the cost (n,) of each node from `end` along a joined edge (inf if none), and the index (n,) of
    that join.
    """
    table = graph.edges
    cost = np.full(len(table.nodes), np.inf)
    by = np.zeros(len(table.nodes), dtype=np.int64)
    for k, (join, way) in enumerate(zip(end.joins.tolist(), end.price + haste * end.length, strict=True)):
        edge = table.edge_of[join]
        whole = table.price[edge] + haste * table.length[edge]
        along = table.price_along[join] + haste * table.along[join]
        for node, rest in zip(table.ends[edge], (along, whole - along), strict=True):
            if way + rest < cost[node]:
                cost[node], by[node] = way + rest, k
    return cost, by


def _on_one_edge(graph: VoronoiGraph, start: _End, goal: _End, haste: float) -> tuple[float, int, int]:
    """Return the cheapest way that leaves an edge before reaching a node: cost and which joins; inf if
    none.
    """
    table = graph.edges
    best = (math.inf, 0, 0)
    for a, i in enumerate(start.joins.tolist()):
        for b, j in enumerate(goal.joins.tolist()):
            if table.edge_of[i] == table.edge_of[j]:
                price = start.price[a] + goal.price[b] + abs(table.price_along[i] - table.price_along[j])
                length = start.length[a] + goal.length[b] + abs(table.along[i] - table.along[j])
                best = min(best, (float(price + haste * length), a, b))
    return best


def _stretch(graph: VoronoiGraph, i: int, j: int) -> IntArray:
    """Return the cells (k, 2) of one edge from its cell i to its cell j, both included."""
    cells = graph.edges.cells
    return cells[i : j + 1] if i <= j else cells[j : i + 1][::-1]


def _to_node(graph: VoronoiGraph, join: int, node: int) -> IntArray:
    """Return the cells (k, 2) from a join along its edge to one of its nodes, the shorter way if both are."""
    table = graph.edges
    edge = table.edge_of[join]
    at_first, at_last = table.ends[edge] == node
    before, after = table.price_along[join], table.price[edge] - table.price_along[join]
    if at_first and (not at_last or before <= after):
        return _stretch(graph, join, int(table.first[edge]))
    return _stretch(graph, join, int(table.first[edge + 1]) - 1)
