"""Routes for a polygonal footprint, which heads where it drives."""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.navigation.maps.blocked_squares import BlockedSquares, blocked_squares, path_clearance
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray

from .route import CORNER_ROUNDING_PASSES, Route, plan_route
from .straight_pass import straight_passes
from .swept_route import swept_room
from .voronoi_graph import VoronoiGraph, voronoi_graph

MAX_TRIES = 8  # places that are closed because the polygon does not pass them, until there is no route
CELL_CENTRES = (0.5, 1.0)  # of a cell that the middle of a gap is off the centres of cells; tried in turn
LEAVING_M = 0.35  # at both ends, where the polygon may have less room


class RouteSettings(NamedTuple):
    """Settings of a route planner, with the clearance to keep and the rounding of corners."""

    room: float
    """Room beside the footprint, in [m]."""
    reach: float
    """Distance that start and goal may be outside the free space, in [m]."""
    rounding: float
    """Length of corners, as a multiple of the usual one."""


def polygon_routing(
    grid: GridMap,
    shape: Footprint,
    start: tuple[float, float],
    goal: tuple[float, float],
    settings: RouteSettings,
    squares: BlockedSquares | None = None,
) -> Generator[None, None, Route | None]:
    """Return a route along which a polygonal robot, turned in the direction of travel, has room; None without
    one.

    The search is a generator of steps; each takes about as long as building a Voronoi graph.

    First a route is planned for the disc inside the polygon, and its corners are rounded. If the polygon does
    not fit along it, the route with its corners is tried. If the polygon fits along neither, the narrow place
    is closed, and another route is planned. If there is none, routes that pass narrow places straight through
    their middle are tried.

    Args:
        grid: the map; unknown cells count as blocked.
        shape: polygon of the footprint.
        start: x and y on the map, in [m].
        goal: x and y on the map, in [m].
        settings: clearance, distance of start and goal from the free space, and rounding of corners.
        squares: blocked squares of the map, if they are known already.
    """
    squares = blocked_squares(grid.blocked) if squares is None else squares
    for may_be_tight in (False, True):
        for off in CELL_CENTRES:
            route = yield from _routing_with(grid, squares, shape, start, goal, settings, off, may_be_tight)
            if route is not None:
                return route
    return None


def _routing_with(
    grid: GridMap,
    squares: BlockedSquares | None,
    shape: Footprint,
    start: tuple[float, float],
    goal: tuple[float, float],
    settings: RouteSettings,
    off_cells: float,
    may_be_tight: bool,
) -> Generator[None, None, Route | None]:
    """Return a route; `off_cells`: how far the cells of its graph may be off a middle; `may_be_tight`: narrow
    places are passed straight through their middle.
    """
    for _ in range(MAX_TRIES):
        try:
            need = shape.inscribed + settings.room - off_cells * grid.resolution
            graph = voronoi_graph(grid, need, start, squares)
        except ValueError:
            return None
        yield
        spot: FloatArray | None = None
        for passes in (CORNER_ROUNDING_PASSES, 2, 0):
            route = plan_route(graph, start, goal, settings.reach, rounding=settings.rounding, passes=passes)
            if route is None:
                return None
            spot = _tight_spot(grid, shape, route.points, settings.room)
            if spot is None:
                return route
            yield
        assert route is not None
        assert spot is not None
        straight = _straight_route(graph, shape, route, spot, settings.room) if may_be_tight else None
        if straight is not None:
            return straight
        grid, squares = grid.with_points(spot[None]), None
        yield
    return None


def _straight_route(
    graph: VoronoiGraph, shape: Footprint, route: Route, spot: FloatArray, room: float
) -> Route | None:
    """Return a route that passes a narrow place straight through its middle; None if it has too little room
    there.
    """
    grid = graph.map
    for points in straight_passes(grid, shape, route.points, spot):
        if _tight_spot(grid, shape, points, room) is None:
            cells = (points[:, ::-1] - (grid.origin_y, grid.origin_x)) / grid.resolution - 0.5
            return Route(points, path_clearance(graph.squares, cells) * grid.resolution)
    return None


def _tight_spot(grid: GridMap, shape: Footprint, points: FloatArray, room: float) -> FloatArray | None:
    """Return the point of a route (n, 2) where the polygon has the least room; None if it has enough."""
    rooms = swept_room(grid, shape, points)
    for end in (points[0], points[-1]):
        rooms[np.hypot(*(points - end).T) < LEAVING_M] = np.inf
    tight = int(np.argmin(rooms))
    return None if rooms[tight] >= room - 1e-9 else points[tight]
