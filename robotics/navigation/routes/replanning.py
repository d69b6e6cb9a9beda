"""Replanning of a route while it is driven: keep it, take another one, or say that no way leads on."""

from __future__ import annotations

from collections.abc import Generator
from typing import Literal, NamedTuple

import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.blocked_squares import BlockedSquares, blocked_squares, path_clearance
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.map_window import window_around
from handcart.robotics.navigation.maps.room_speeds import RoomSpeeds
from handcart.robotics.navigation.maps.speed_limits import AllowedSpeeds
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.numerics.stepwise import finish

from .shortcuts import path_length
from .swept_route import swept_room
from .voronoi_graph import STEP_CELLS
from .ways import Ways, narrowest_room

ROOMS_M = (0.06, 0.02, -0.015)  # beside the footprint that routes keep, in the order in which they are tried
EDGE_JITTER_M = 0.04  # by which cells of an obstacle's edge come and go: a route is not left for less
WORTH_RATIO = 0.85  # of the old route's price, below which another one is taken although the old one is free
MAX_ROOMY_LENGTH_RATIO = 1.2  # of the usual length, up to which the first way with room is taken
ROOMY_DETOUR_RATIO = 0.8  # of the length of a roomy way, below which a narrower one is taken instead
OFF_ROUTE_M = 0.3  # from the old route, beyond which it is not the robot's any more
MARGIN_CELLS = 2  # beyond the distance that matters, so that the edge of a window is not an obstacle
USUAL_SPEED_M_S = 0.6  # of robots whose corners have the usual length


class RouteLook(NamedTuple):
    """Decision on a route, whether to keep it or take another one, and how much of it is free."""

    kind: Literal["kept", "new", "none"]
    """Decision: keep the old route, take another one, or none leads to the goal."""
    points: FloatArray
    """(n, 2) route to drive, from the robot on, on the map, in [m]; the old one where no way leads on."""
    free: float
    """Length of the points that is free, in [m]."""
    obstacle: tuple[float, float] | None
    """Position on the map of the first point of the route that is not free, in [m]; None if all are."""
    speeds: RoomSpeeds
    """Speed limits by the room beside the footprint."""


class Replanner:
    """Planner that decides whether to keep a route or to take another one.

    A free route is kept as long as no other route costs less than `WORTH_RATIO` times its cost. So the robot
    does not alternate between two routes of about the same cost.
    """

    def __init__(
        self,
        radius: float | Footprint,
        top_speed: float = USUAL_SPEED_M_S,
        speeds: AllowedSpeeds | None = None,
        rooms: tuple[float, ...] = ROOMS_M,
    ) -> None:
        """Replan for a robot.

        Args:
            radius: radius of its footprint, in [m], or its footprint.
            top_speed: in [m/s]; faster robots get rounder corners.
            speeds: speed limits by position, in addition to those by room.
            rooms: room beside the footprint that routes keep, in [m], the first one that leads to the goal.
        """
        self._shape = radius if isinstance(radius, Footprint) else Footprint(radius)
        self._radius, self._speeds, self._rooms = self._shape.inscribed, speeds, rooms
        self._rounding = max(1.0, top_speed / USUAL_SPEED_M_S)
        self._room = rooms[0]
        self._blocked: BoolArray | None = None
        self._squares: BlockedSquares | None = None
        self._planned_on: BlockedSquares | None = None

    def look(
        self,
        grid: GridMap,
        start: Pose2,
        goal: Pose2,
        front: FloatArray | None = None,
        route: FloatArray | None = None,
        lead: float = 0.0,
        better: bool = True,
    ) -> RouteLook:
        """Decide whether to keep the old route to a goal or to take a new one.

        Args:
            grid: the map with the sensed obstacles.
            start: map_T_base.
            goal: map_T_base at the goal.
            front: (2, 2) ends of a straight front on the map, in [m], in front of which the robot has to
                stop; None: the goal has no front.
            route: (n, 2) rest of the old route, from the robot on, on the map, in [m]; None: no old route.
            lead: length of the old route, from the robot on, that a new route has to keep, in [m].
            better: True to look for another route although the old one is free.
        """
        return finish(self.looking(grid, start, goal, front, route, lead, better))

    def looking(
        self,
        grid: GridMap,
        start: Pose2,
        goal: Pose2,
        front: FloatArray | None = None,
        route: FloatArray | None = None,
        lead: float = 0.0,
        better: bool = True,
    ) -> Generator[None, None, RouteLook]:
        """Decide whether to keep the old route to a goal or to take a new one, as a generator.

        A step of the generator takes at most about as long as thinning the free space of the map.

        Args:
            grid: the map with the sensed obstacles.
            start: map_T_base.
            goal: map_T_base at the goal.
            front: (2, 2) ends of a straight front on the map, in [m], in front of which the robot has to
                stop; None: the goal has no front.
            route: (n, 2) rest of the old route, from the robot on, on the map, in [m]; None: no old route.
            lead: length of the old route that a new route has to keep, in [m].
            better: True to look for another route although the old one is free.
        """
        squares = self._squares_of(grid)
        clearance = squares.distance[1:-1, 1:-1] * np.float32(grid.resolution)
        speeds = RoomSpeeds(grid, clearance, self._radius, self._speeds)
        old = None if route is None or len(route) < 2 else _Driven(route, grid, squares, self._shape)
        if old is not None and old.away(start) > OFF_ROUTE_M:
            old = None
        if old is None:
            free, obstacle = 0.0, None
        else:
            free, obstacle = old.free(self._radius + self._room - EDGE_JITTER_M, front)
        is_free = old is not None and obstacle is None
        if old is not None and is_free and not better:
            return RouteLook("kept", old.points, free, None, speeds)
        head = np.empty((0, 2)) if old is None else old.head(min(lead, 0.5 * free))
        usual = start.distance(goal) if old is None else max(start.distance(goal), path_length(old.points))
        if old is not None and is_free and self._planned_on is squares:
            return RouteLook("kept", old.points, free, None, speeds)  # it is what the rest of that plan is
        if grid.occupied.size > STEP_CELLS:
            yield
        plan = yield from self._planning(grid, squares, start, goal, front, head, usual)
        self._planned_on = squares
        if old is not None and (plan is None or (is_free and not plan.is_worth(old.points))):
            return RouteLook("kept" if is_free else "none", old.points, free, obstacle, speeds)
        if plan is None:
            return RouteLook("none", np.array([start[:2]]), 0.0, obstacle, speeds)
        self._room = plan.room
        return RouteLook("new", plan.points, path_length(plan.points), None, speeds)

    def _squares_of(self, grid: GridMap) -> BlockedSquares:
        """Return the distances to what is blocked, computed again only where that has changed."""
        blocked = grid.blocked
        if self._blocked is None or self._squares is None or not np.array_equal(blocked, self._blocked):
            self._blocked, self._squares = blocked, blocked_squares(blocked)
        return self._squares

    def _planning(
        self,
        grid: GridMap,
        squares: BlockedSquares,
        start: Pose2,
        goal: Pose2,
        front: FloatArray | None,
        head: FloatArray,
        usual: float,
    ) -> Generator[None, None, _Plan | None]:
        """Return the plan with the most room that leads to the goal; None if none does.

        Where room costs much more than the `usual` length in [m], a narrower way that is much shorter counts.
        """
        begin = (float(head[-1, 0]), float(head[-1, 1])) if len(head) else (start[0], start[1])
        found: _Plan | None = None
        narrowest = () if self._shape.is_disc else (narrowest_room(grid),)
        for room in (*self._rooms, *narrowest):
            ways = Ways(grid, self._shape, begin, room=room, rounding=self._rounding, squares=squares)
            if front is None:
                route = yield from ways.routing_to(goal)
            else:
                route = ways.to(goal, front).route
            if route is None:
                yield
                continue
            points = np.vstack([head[:-1], route.points]) if len(head) else route.points
            plan = _Plan(points, room, ways)
            if found is None or plan.length < ROOMY_DETOUR_RATIO * found.length:
                found = plan
            if found is not plan or plan.length < MAX_ROOMY_LENGTH_RATIO * usual:
                break
            yield
        return found


def free_length(grid: GridMap, route: FloatArray, least: float) -> tuple[float, tuple[float, float] | None]:
    """Return the length of a route's free beginning, in [m], and the first point that is not free, None
    without one.

    Args:
        grid: the map with the sensed obstacles.
        route: (n, 2) points of the route on the map, in [m], at least two.
        least: distance that the robot's centre needs from obstacles, in [m].
    """
    low, high = route.min(axis=0), route.max(axis=0)
    half = float(0.5 * (high - low).max()) + least + MARGIN_CELLS * grid.resolution
    x, y = 0.5 * (low + high)
    near = window_around(grid, float(x), float(y), half)
    return _Driven(route, near, blocked_squares(near.blocked)).free(least, None)


class _Plan(NamedTuple):
    """Answer of the planner."""

    points: FloatArray
    """(n, 2) the complete route in [m]."""
    room: float
    """Room beside the footprint that it keeps, in [m]."""
    ways: Ways

    @property
    def length(self) -> float:
        """Length of the route in [m]."""
        return path_length(self.points)

    def is_worth(self, old: FloatArray) -> bool:
        """Return whether it costs enough less than an old route (n, 2) that is free."""
        return self.ways.price(self.points) < WORTH_RATIO * self.ways.price(old)


class _Driven:
    """A route that is being driven, on a map with what was sensed."""

    def __init__(
        self, points: FloatArray, grid: GridMap, squares: BlockedSquares, shape: Footprint | None = None
    ) -> None:
        self.points = points
        self._along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        corner = np.array([grid.origin_y, grid.origin_x])
        cells = (points[:, ::-1] - corner) / grid.resolution - 0.5
        inside = np.clip(cells, 0.0, np.array(grid.occupied.shape) - 1.0)
        self._room = path_clearance(squares, inside) * grid.resolution
        if shape is not None and not shape.is_disc:
            self._room = np.minimum(self._room, swept_room(grid, shape, points) + shape.inscribed)

    def away(self, start: Pose2) -> float:
        """Return the distance of the robot from the route's points, in [m]."""
        return float(np.hypot(*(self.points - start[:2]).T).min())

    def head(self, length: float) -> FloatArray:
        """Return the first points (k, 2) on the map, up to about this length in [m]; empty if too few."""
        found = self.points[self._along <= length]
        return found if len(found) > 1 else np.empty((0, 2))

    def free(self, least: float, front: FloatArray | None) -> tuple[float, tuple[float, float] | None]:
        """Return the length that has at least this room in [m], and the point that has less, if one exists.

        The beginning of a route that leads away from something too near counts as free, and so does what is
        as near as the front before which it ends.
        """
        tight = self._room < least
        leaving = np.maximum.accumulate(self._room) <= self._room + 1e-6
        tight &= ~np.logical_and.accumulate(tight & leaving)
        if front is not None:
            tight &= self._along < self._along[-1] - least
        if not tight.any():
            return float(self._along[-1]), None
        first = int(np.argmax(tight))
        return float(self._along[first]), (float(self.points[first, 0]), float(self.points[first, 1]))
