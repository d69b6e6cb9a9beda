"""Routes across large maps: planned on larger cells, and on the map's own cells about their goal."""

from __future__ import annotations

import math
from collections.abc import Generator

import cv2
import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.map_window import (
    coarsened,
    window_around,
    with_cells_at,
)
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .route import plan_route
from .voronoi_graph import VoronoiGraph, voronoi_graph
from .ways import ROUTE_ROOM_M, Ways

COARSE_CELL_COUNT = 1_000_000  # of a map with larger cells, at most
MAX_COARSE_CELL_M = 0.4  # larger ones close usual aisles
SNAP_M = 2.5  # from start and goal, to where larger cells have room
HANDOVER_ROOM_M = 0.15  # beside the footprint, where a part of a route on a window ends
WINDOW_MARGIN_M = 2.0  # from a window's border, that a part of a route on it keeps


class FarPlanner:
    """Planner of routes on a large map, which is fast because it uses larger cells.

    A larger cell is occupied if any of the map's cells in it is, so a route over larger cells is free. Narrow
    passages may be closed by larger cells, so there may be a route although this planner finds none.
    """

    def __init__(self, grid: GridMap, shape: Footprint, radius: float, half: float) -> None:
        """Prepare a map.

        Args:
            grid: the map.
            shape: footprint of the robot.
            radius: of a circle around the footprint, in [m].
            half: half of the side of the window about a goal in which the map's own cells count, in [m].
        """
        self._grid, self._shape, self._radius, self._half = grid, shape, radius, half
        widest = max(1, int(MAX_COARSE_CELL_M / grid.resolution + 1e-9))
        factor = min(widest, math.ceil(math.sqrt(grid.occupied.size / COARSE_CELL_COUNT)))
        self._coarse = coarsened(grid, factor)
        self._built: tuple[BoolArray, VoronoiGraph | None] | None = None

    def routing(
        self, start: Pose2, goal: Pose2, front: FloatArray | None, sensed: FloatArray
    ) -> Generator[None, None, FloatArray | None]:
        """Return the points (n, 2) of a route on the map, in [m]; None if none was found.

        The method is a generator: each step takes about as long as building a Voronoi graph. The graph has
        larger cells than the map. The first part of the route leads from the start to the nearest free one of
        these cells; it is not checked for obstacles.

        Args:
            start: map_T_base.
            goal: map_T_base at the goal.
            front: (2, 2) ends of a straight front on the map, in [m], in front of which the robot has to
                stop; None: the goal has no front.
            sensed: (n, 2) points on the map that are avoided as well, in [m].
        """
        graph = self._graph_with(sensed, start)
        yield
        if graph is None:
            return None
        ends = [_nearest_free(graph, point) for point in (start, goal)]
        if ends[0] is None or ends[1] is None:
            return None
        far = plan_route(graph, ends[0], ends[1], reach=graph.map.resolution)
        yield
        if far is None:
            return None
        points = np.vstack([[start[:2]], far.points])
        around = with_cells_at(window_around(self._grid, goal.x, goal.y, self._half), sensed)
        begin = _entry(points, around, self._radius, self._grid)
        ways = Ways(around, self._shape, (float(points[begin, 0]), float(points[begin, 1])))
        last = ways.to(goal, front).route
        return None if last is None else np.vstack([points[:begin], last.points])

    def _graph_with(self, sensed: FloatArray, start: Pose2) -> VoronoiGraph | None:
        """Return the graph of the larger cells, built again only where these have changed."""
        grid, built = with_cells_at(self._coarse, sensed), self._built
        if built is not None and np.array_equal(grid.blocked, built[0]):
            return built[1]
        try:
            graph = voronoi_graph(grid, self._radius + ROUTE_ROOM_M, seed_point=(start.x, start.y))
        except ValueError:
            graph = None
        self._built = grid.blocked, graph  # both at once: another thread may plan while this one builds
        return graph


def split(route: FloatArray, window: GridMap, radius: float, grid: GridMap) -> int:
    """Return how many of a route's first points are to be planned again within a window of the map.

    The last of them is in the window, with room for the footprint around it if there is such a point.

    Args:
        route: (n, 2) points of the route on the map, in [m]; the route begins in the window.
        window: part of the map, with the sensed obstacles.
        radius: radius of the footprint, in [m].
        grid: the map; next to its own borders the route needs no margin, because nothing is beyond them.
    """
    inside = _is_inner(route, window, grid)
    count = len(route) if inside.all() else int(np.argmin(inside))
    if count == len(route):
        return count
    roomy = _room(window, route[:count]) > radius + HANDOVER_ROOM_M
    return int(np.flatnonzero(roomy)[-1]) + 1 if roomy.any() else max(count, 1)


def _is_inner(points: FloatArray, window: GridMap, grid: GridMap) -> BoolArray:
    """Return a mask (n,), True for points (n, 2) with a margin to the sides on which the map goes on."""
    (low, high), (least, most) = _corners(window), _corners(grid)
    low = np.where(low > least + window.resolution, low + WINDOW_MARGIN_M, low)
    high = np.where(high < most - window.resolution, high - WINDOW_MARGIN_M, high)
    return np.asarray(np.all((points >= low) & (points <= high), axis=1))


def _corners(grid: GridMap) -> tuple[FloatArray, FloatArray]:
    low = np.array([grid.origin_x, grid.origin_y])
    return low, low + np.array(grid.occupied.shape[::-1]) * grid.resolution


def _entry(route: FloatArray, window: GridMap, radius: float, grid: GridMap) -> int:
    """Return the number of the point from which a route to a window's middle is planned on the window."""
    return len(route) - split(route[::-1], window, radius, grid)


def _room(grid: GridMap, points: FloatArray) -> FloatArray:
    """Return the distance (n,) of points (n, 2) to the centre of the nearest blocked cell, in [m]."""
    free = np.ascontiguousarray(~grid.blocked).view(np.uint8)
    if free.all():
        return np.full(len(points), np.inf)
    away = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    rows, columns = np.clip(grid.to_cell(points), 0, np.array(free.shape) - 1).T
    return np.asarray(away[rows, columns] * grid.resolution, dtype=np.float64)


def _nearest_free(graph: VoronoiGraph, point: Pose2) -> tuple[float, float] | None:
    """Return the nearest place with room on a graph's map, in [m]; None if it is farther than `SNAP_M`."""
    near = window_around(graph.map, point.x, point.y, SNAP_M)
    row, column = graph.map.to_cell(np.array([[near.origin_x, near.origin_y]]) + 0.5 * near.resolution)[0]
    height, width = near.occupied.shape
    centres = near.to_point(np.argwhere(graph.free[row : row + height, column : column + width]))
    if not len(centres):
        return None
    x, y = centres[int(np.argmin(np.hypot(*(centres - point[:2]).T)))].tolist()
    return x, y
