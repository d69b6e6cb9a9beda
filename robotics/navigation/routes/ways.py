"""Goals that a round robot can occupy on a map, and routes to them from its pose."""

from __future__ import annotations

import math
from collections.abc import Generator
from contextlib import suppress
from functools import cached_property
from typing import Literal, NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.blocked_squares import BlockedSquares
from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.polygon_route import RouteSettings, polygon_routing
from handcart.robotics.navigation.routes.route import Route, routing
from handcart.robotics.navigation.routes.voronoi_graph import (
    DISTANCE_TOLERANCE,
    STEP_CELLS,
    VoronoiGraph,
    graphing,
)
from handcart.robotics.navigation.routes.widest_way import narrowest_spot
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray
from handcart.robotics.numerics.stepwise import finish

ROUTE_ROOM_M = 0.02  # [m] beside the footprint that a route keeps
# by which a polygon may reach into cells of a map: they draw narrow doors narrower, on both sides
POLYGON_OVERLAP_CELLS = 0.9
ROOM_AT_GOAL = 0.04  # [m] likewise at the robot's goal: it stops within half of that
SENSED_ROOM = 0.10  # [m] that what was sensed is grown by: its far side wasn't seen
ROOM_BEFORE = 0.02  # [m] likewise before the object that the robot stops at
# [m]: cells larger than that leave a pose unsure, by `CELL_UNCERTAINTY` of what they are larger
FINE_CELL_M = 0.05
CELL_UNCERTAINTY = 0.5  # of a cell: the farthest that a surface lies from its cell's centre
# [m] beside the footprint that is left in any case, but on the way out of a start without it
MIN_ROOM_M = 0.01
LEAVING_DISTANCE_M = 0.25  # [m] at most, from a start that is too near to something to where there is room

NO_POINTS = np.empty((0, 2))

Kind = Literal["something", "unknown space", "the map's edge", "its front", "nothing"]
Why = Literal["", "too near", "too narrow", "cut off"]


class Way(NamedTuple):
    """A goal's clearance, and the route to it or the reason why it has no route."""

    clearance: float
    """Distance from the goal to the nearest obstacle, in [m]."""
    needed: float
    """Distance needed at the goal, in [m]."""
    nearest: tuple[float, float]
    """Nearest point of the nearest obstacle, in [m]; NaN without obstacles."""
    kind: Kind
    """Kind of the nearest obstacle."""
    component: int | None
    """Number, by size from 1, of the connected part of free space that holds the goal; None if in no such
    part.
    """
    route: Route | None
    """Route to the goal, or None."""
    why: Why
    """Reason why the goal has no route."""
    narrow: tuple[float, float] | None = None
    """Position on the map of the place that is too narrow, in [m]; None if no such place is known."""
    width: float = math.nan
    """Width of the place that is too narrow, in [m]."""
    width_needed: float = math.nan
    """Width needed there, in [m]."""

    @property
    def fits(self) -> bool:
        """True if the distance from the goal to obstacles is enough for the robot (at least `needed`)."""
        return self.why != "too near"

    @property
    def reason(self) -> str:
        """Reason why the goal has no route, as text for people; empty if it has one."""
        if self.why == "too near":
            x, y = self.nearest
            there = f"{self.kind} at ({x:.2f}, {y:.2f}) m"
            return f"{there} leaves {self.clearance:.3f} m to its middle, needed: {self.needed:.3f} m"
        if self.narrow is None:
            return "it is cut off: no free space leads there" if self.why else ""
        x, y = self.narrow
        wide = f"{self.width:.2f} m wide at ({x:.2f}, {y:.2f}) m"
        return f"the way is too narrow: {wide}, needed: {self.width_needed:.2f} m"


def narrowest_room(grid: GridMap) -> float:
    """Return the least distance to obstacles, in [m], that a planned route may leave a polygonal footprint.

    The distance is negative: a small overlap with the squares of blocked cells is allowed.
    """
    return -POLYGON_OVERLAP_CELLS * grid.resolution


class Ways:
    """Planner of routes on a map from a robot's present position to any goal."""

    def __init__(
        self,
        grid: GridMap,
        radius: float | Footprint,
        start: Pose2 | tuple[float, float],
        sensed: FloatArray = NO_POINTS,
        room: float | None = None,
        rounding: float = 1.0,
        squares: BlockedSquares | None = None,
    ) -> None:
        """Prepare routes on a map.

        Args:
            grid: the map; unknown cells and everything beyond the map count as obstacles.
            radius: radius of the robot's footprint, in [m], or its footprint: routes lead where a polygon
                passes at the heading of travel.
            start: position of the robot; only x and y count, in [m].
            sensed: (n, 2) points that are avoided as well, in [m]; along the route by more than at its
                ends.
            room: room beside the footprint that routes keep, in [m] (default: `ROUTE_ROOM_M`, or
                `narrowest_room` of a polygon); below zero where cells are coarse and what they hold is
                narrower than they are.
            rounding: length of corners, as a multiple of the usual one; more for faster robots.
            squares: blocked squares of the map without `sensed`, if they are known already.
        """
        self._shape = radius if isinstance(radius, Footprint) else Footprint(radius)
        self._grid, self._radius, self._start = (
            grid.with_points(sensed),
            self._shape.inscribed,
            (start[0], start[1]),
        )
        usual = ROUTE_ROOM_M if self._shape.is_disc else narrowest_room(grid)
        self._room, self._rounding = usual if room is None else room, rounding
        self._grown = grid.with_points(sensed, SENSED_ROOM)
        self._squares = None if len(sensed) else squares
        self._built: VoronoiGraph | None = None
        self._is_built = False

    def to(self, goal: Pose2 | tuple[float, float], front: FloatArray | None = None) -> Way:
        """Return the clearance at a goal and the route to it, or the reason why there is no route.

        Args:
            goal: position on the map, in [m]; a heading is ignored.
            front: (2, 2) ends of a straight front on the map, in [m], in front of which the robot has to
                stop. The front replaces the obstacles of the map there; the robot may come nearer to the
                front than to other obstacles. None: the goal has no front.
        """
        here = (goal[0], goal[1])
        if front is None:
            return self._to(here, self._standing(here), None)
        mapped = without_front(self._grid, front)
        before = Ways(mapped, self._shape, self._start, NO_POINTS, self._room, self._rounding)
        before._grown = without_front(self._grown, front)
        stands = before._standing(here, front)
        found = self._to(here, stands, front)
        return found if found.route is not None or not found.fits else before._to(here, stands, front)

    def routing_to(self, goal: Pose2 | tuple[float, float]) -> Generator[None, None, Route | None]:
        """Return the route to a goal, None if no route exists; a generator that yields after each computing
        step.

        A step takes at most about as long as thinning the free space of the map.
        """
        there = (goal[0], goal[1])
        if not self._shape.is_disc:
            route = yield from self._routing_of_polygon(there)
        else:
            graph = yield from self._graphing()
            if graph is not None and self._grid.occupied.size > STEP_CELLS:
                yield
            route = None if graph is None else (yield from self._routing(there))
        if route is None or route.clearance[-1] < self._needed - 1e-9:
            return None
        return route if self._tight_spot(route, None) is None else None

    def price(self, points: FloatArray) -> float:
        """Return the price of a path on this map: its length in [m], multiplied in each cell by a factor that
        is larger the nearer obstacles are.

        The price is infinite if the robot fits nowhere on the map.

        Args:
            points: (n, 2) on the map, in [m], each at most a few cells from the next.
        """
        if self._graph is None:
            return math.inf
        steps = np.hypot(*np.diff(points, axis=0).T)
        cells = self._grid.to_cell(0.5 * (points[1:] + points[:-1]))
        rows, columns = np.clip(cells, 0, np.array(self._grid.occupied.shape) - 1).T
        return float(steps @ self._graph.price[rows, columns])

    def _to(self, goal: tuple[float, float], stands: Way, front: FloatArray | None) -> Way:
        if stands.why:
            return stands
        found = stands._replace(component=self._component(goal))
        if self._graph is None:
            return found._replace(why="too narrow")
        route = self._planned(goal)
        if route is None:
            return self._without_way(found, goal, self._reach)
        tight = self._tight_spot(route, front)
        return found._replace(route=route) if tight is None else self._too_narrow(found, tight)

    @property
    def _reach(self) -> float:
        """Distance that start and goal may be outside the free space, in [m]."""
        return min(LEAVING_DISTANCE_M, 0.7 * self._needed)

    def _planned(self, goal: tuple[float, float]) -> Route | None:
        """Return the route to a goal that the footprint passes; None without one."""
        return finish(self._routing(goal) if self._shape.is_disc else self._routing_of_polygon(goal))

    def _routing(self, goal: tuple[float, float]) -> Generator[None, None, Route | None]:
        assert self._graph is not None
        return routing(self._graph, self._start, goal, self._reach, rounding=self._rounding)

    def _routing_of_polygon(self, goal: tuple[float, float]) -> Generator[None, None, Route | None]:
        settings = RouteSettings(self._room + self._unsure, self._reach, self._rounding)
        return polygon_routing(self._grown, self._shape, self._start, goal, settings, self._squares)

    def _standing(self, goal: tuple[float, float], front: FloatArray | None = None) -> Way:
        """Return the clearance at a goal, with "too near" as reason if the robot does not fit."""
        distance, point = self._clearances.nearest(goal)
        at, needed, kind = (float(point[0]), float(point[1])), self._needed, self._kind(point)
        if front is not None:
            before, foot = _to_segment(goal, front)
            if before - self._radius - ROOM_BEFORE < distance - self._needed:
                distance, at, needed, kind = before, foot, self._radius + ROOM_BEFORE, "its front"
        near = distance < needed - 1e-9
        return Way(distance, needed, at, kind, None, None, "too near" if near else "")

    def _kind(self, point: FloatArray) -> Kind:
        """Return the kind of obstacle at a point on the border of a cell."""
        if not np.isfinite(point).all():
            return "nothing"
        around = point + 1e-6 * np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])
        inside = around[self._grid.inside(around)]
        rows, columns = self._grid.to_cell(inside).T
        if self._grid.occupied[rows, columns].any():
            return "something"
        return "unknown space" if self._grid.unknown[rows, columns].any() else "the map's edge"

    def _component(self, goal: tuple[float, float]) -> int | None:
        cell = self._near_free(self._labels > 0, goal, 0.5 * self._needed)
        return None if cell is None else int(self._labels[cell])

    def _near_free(self, free: BoolArray, point: tuple[float, float], reach: float) -> tuple[int, int] | None:
        rows, columns = np.nonzero(free)
        row, column = self._grid.to_cell(np.array([point]))[0].tolist()
        if len(rows) == 0:
            return None
        away = np.hypot(rows - row, columns - column)
        nearest = int(np.argmin(away))
        near = away[nearest] <= math.ceil(reach / self._grid.resolution)
        return (int(rows[nearest]), int(columns[nearest])) if near else None

    def _without_way(self, found: Way, goal: tuple[float, float], reach: float) -> Way:
        """Return why no route leads to the goal: too narrow, or cut off."""
        assert self._graph is not None
        clearance, open_ = self._graph.clearance, self._graph.clearance > 0.0
        ends = [self._near_free(open_, point, reach) for point in (self._start, goal)]
        if ends[0] is None or ends[1] is None:
            return found._replace(why="cut off")
        spot = narrowest_spot(clearance, ends[0], ends[1])
        if spot is None:
            return found._replace(why="cut off")
        return self._too_narrow(found, self._grid.to_point(np.array([spot]))[0])

    def _too_narrow(self, found: Way, at: FloatArray) -> Way:
        width, needed = self._width(at), 2.0 * (self._radius + self._room + self._unsure)
        if width >= needed:  # ways are looked for from cell to cell
            needed += self._grid.resolution
        spot = (float(at[0]), float(at[1]))
        return found._replace(why="too narrow", narrow=spot, width=width, width_needed=max(needed, width))

    def _width(self, at: FloatArray) -> float:
        """Return the distance between the obstacles on both sides of a point, in [m]."""
        distance, point = self._clearances.nearest((float(at[0]), float(at[1])))
        if not 0.0 < distance < math.inf:
            return 0.0
        away = (at - point) / distance
        other, left = distance, math.inf
        while left > 1e-3:
            left = self._clearances.nearest(tuple((at + (other - distance) * away).tolist())).distance
            other += max(left, 0.0)
        return other

    def _tight_spot(self, route: Route, front: FloatArray | None) -> FloatArray | None:
        """Return the route's point (2,) with too little clearance, on the map in [m].

        Its beginning is excepted; None if it has no such point.
        """
        if not self._shape.is_disc and front is None:
            return None  # `polygon_route` has looked at the room along it
        points, room = route.points, route.clearance
        if front is not None:
            room = np.minimum(room, [_to_segment((x, y), front)[0] for x, y in points.tolist()])
        leaving = (np.hypot(*(points - self._start).T) < LEAVING_DISTANCE_M) & (room >= room[0] - 1e-6)
        tight = (room < self._radius + min(MIN_ROOM_M, self._room) - 1e-9) & ~leaving
        return points[int(np.argmin(np.where(tight, room, np.inf)))] if tight.any() else None

    @property
    def _needed(self) -> float:
        at_goal = min(ROOM_AT_GOAL, self._room + ROOM_AT_GOAL - ROUTE_ROOM_M)
        return self._radius + at_goal + self._unsure

    @property
    def _unsure(self) -> float:
        """Pose uncertainty added by cells coarser than `FINE_CELL_M`, in [m]."""
        return CELL_UNCERTAINTY * max(0.0, self._grid.resolution - FINE_CELL_M)

    @cached_property
    def _clearances(self) -> Clearances:
        return Clearances(self._grid, self._grid.blocked, walled=True)

    @property
    def _graph(self) -> VoronoiGraph | None:
        return finish(self._graphing())

    def _graphing(self) -> Generator[None, None, VoronoiGraph | None]:
        """Return the graph of the ways, None if the robot fits nowhere; the first call builds it in steps."""
        if not self._is_built:
            room = self._radius + self._room + self._unsure
            with suppress(ValueError):
                self._built = yield from graphing(self._grown, room, self._start, self._squares)
            self._is_built = True
        return self._built

    @cached_property
    def _labels(self) -> IntArray:
        """(h, w) part of the map that each cell belongs to, 1 the largest; 0 where the robot can't be."""
        if self._graph is None:
            return np.zeros(self._grid.occupied.shape, dtype=np.int64)
        free = (self._graph.clearance >= self._graph.radius * (1.0 - DISTANCE_TOLERANCE)).astype(np.uint8)
        count, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=8)
        order = 1 + np.argsort(-stats[1:, cv2.CC_STAT_AREA], kind="stable")
        numbers = np.zeros(count, dtype=np.int64)
        numbers[order] = np.arange(1, count)
        return np.asarray(numbers[labels])


def without_front(grid: GridMap, front: FloatArray) -> GridMap:
    """Return a map on which the cells along the straight front of an object, at which the base docks, are
    free.

    The front's clearance is checked separately, because its position is known more exactly than the map's
    cells are.

    Args:
        grid: the map.
        front: (2, 2) ends of the front on the map, in [m].
    """
    near = 0.75 * grid.resolution
    rows, columns = np.nonzero(grid.blocked)
    centres = grid.to_point(np.column_stack([rows, columns]))
    low, high = front.min(axis=0) - near, front.max(axis=0) + near
    candidates = np.flatnonzero(np.all((centres >= low) & (centres <= high), axis=1))
    gone = [i for i in candidates if _to_segment(tuple(centres[i].tolist()), front)[0] <= near]
    kept = np.ones(grid.occupied.shape, dtype=np.bool_)
    kept[rows[gone], columns[gone]] = False
    return grid._replace(occupied=grid.occupied & kept, unknown=grid.unknown & kept)


def _to_segment(point: tuple[float, float], segment: FloatArray) -> tuple[float, tuple[float, float]]:
    """Distance of a point to a segment (2, 2), and the point of it that is nearest, in [m]."""
    ray = segment[1] - segment[0]
    at = float(np.clip((np.array(point) - segment[0]) @ ray / max(ray @ ray, 1e-12), 0.0, 1.0))
    foot = segment[0] + at * ray
    return math.hypot(point[0] - foot[0], point[1] - foot[1]), (float(foot[0]), float(foot[1]))
