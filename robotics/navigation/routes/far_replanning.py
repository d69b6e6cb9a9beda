"""Replanning on large maps: what is near on the map's own cells, what is far on larger ones."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.map_window import is_within, with_cells_at
from handcart.robotics.navigation.maps.speed_limits import AllowedSpeeds
from handcart.robotics.numerics.arrays import FloatArray

from .far_planning import WINDOW_MARGIN_M, FarPlanner, split
from .replanning import Replanner, RouteLook
from .shortcuts import path_length

WHOLE_PERIOD_S = 10.0  # between two searches on all cells of the map, which take seconds


class FarReplanner:
    """Planner on a large map that decides whether to keep a route or to take another one.

    Only the part of the route within a window around the robot is checked. The rest is a far route, planned
    by `FarPlanner` on larger cells. If no route leads on within the window, another far route is searched. If
    there is none, a route is searched on all cells of the map, because larger cells close narrow passages.
    """

    def __init__(
        self,
        grid: GridMap,
        shape: Footprint,
        radius: float,
        half: float,
        top_speed: float,
        speeds: AllowedSpeeds | None,
    ) -> None:
        """Prepare a map.

        Args:
            grid: the map.
            shape: footprint of the robot.
            radius: of a circle around the footprint, in [m].
            half: half of the side of windows, in [m].
            top_speed: in [m/s].
            speeds: speed limits by position, in addition to those by room.
        """
        self._grid, self._radius = grid, radius
        self._settings = shape, top_speed, speeds
        self._near = Replanner(*self._settings)
        self._far = FarPlanner(grid, shape, radius, half)
        self._next_whole = -math.inf

    def looking(
        self,
        window: GridMap,
        sensed: FloatArray,
        start: Pose2,
        goal: Pose2,
        front: FloatArray | None,
        route: FloatArray | None,
        lead: float,
        better: bool,
        time: float,
    ) -> Generator[None, None, RouteLook]:
        """Decide whether to keep the old route or take a new one, as a generator that computes in steps.

        A step takes about as long as building a Voronoi graph of the window.

        Args:
            window: part of the map about the robot, with the sensed obstacles.
            sensed: (n, 2) obstacle points sensed anywhere on the map, in [m].
            start: current map_T_base.
            goal: map_T_base at the goal.
            front: (2, 2) ends of a straight front on the map, in [m], in front of which the robot has to
                stop; None: the goal has no front.
            route: (n, 2) rest of the old route on the map, from the robot on, in [m]; None: no old route.
            lead: length of the old route, from the robot on, that a new route has to keep, in [m].
            better: True to look for a better route although the old one is free.
            time: current time, in [s]; a search on all cells of the map runs only every `WHOLE_PERIOD_S`,
                unless nothing else leads to a decision.
        """
        if route is not None and len(route) > 1:
            look = yield from self._along(window, start, goal, front, route, lead, better)
            if look.kind != "none":
                return look
        elif is_within(window, np.array([goal[:2]]), WINDOW_MARGIN_M)[0]:
            look = yield from self._near.looking(window, start, goal, front, None, lead, better)
            if look.kind != "none":
                return look
        else:
            look = None
        yield
        far = yield from self._far.routing(start, goal, front, sensed)
        if far is not None:
            count = split(far, window, self._radius, self._grid)
            found = yield from self._beginning(window, start, goal, front, far, count)
            if found.kind == "new":
                return found
            look = found if look is None else look
        if time < self._next_whole and look is not None:
            return look
        self._next_whole = time + WHOLE_PERIOD_S
        yield
        whole = with_cells_at(self._grid, sensed)
        found = yield from Replanner(*self._settings).looking(whole, start, goal, front)
        return found if found.kind == "new" or look is None else look

    def _along(
        self,
        window: GridMap,
        start: Pose2,
        goal: Pose2,
        front: FloatArray | None,
        route: FloatArray,
        lead: float,
        better: bool,
    ) -> Generator[None, None, RouteLook]:
        """Look at the part of a route within the window."""
        count = split(route, window, self._radius, self._grid)
        if count == len(route):
            return (yield from self._near.looking(window, start, goal, front, route, lead, better))
        here, rest = route[:count], route[count:]
        there = Pose2(float(here[-1, 0]), float(here[-1, 1]), 0.0)
        look = yield from self._near.looking(window, start, there, None, here, lead, better)
        return _joined(look, rest)

    def _beginning(
        self,
        window: GridMap,
        start: Pose2,
        goal: Pose2,
        front: FloatArray | None,
        far: FloatArray,
        count: int,
    ) -> Generator[None, None, RouteLook]:
        """Plan the part of a far route within the window."""
        if count == len(far):
            return (yield from self._near.looking(window, start, goal, front))
        there = Pose2(float(far[count - 1, 0]), float(far[count - 1, 1]), 0.0)
        return _joined((yield from self._near.looking(window, start, there)), far[count:])


def _joined(look: RouteLook, rest: FloatArray) -> RouteLook:
    """Return a look at the beginning of a route with the rest of the route, which counts as free if the
    beginning is.
    """
    points = np.vstack([look.points, rest])
    is_free = look.kind != "none" and look.obstacle is None
    added = path_length(points) - path_length(look.points) if is_free else 0.0
    return look._replace(points=points, free=look.free + added)
