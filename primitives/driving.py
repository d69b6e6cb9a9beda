"""What MOVE_TO and MODIFY share: planning a drive, and seeing what stands in its way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from backends.robot import Robot
from robotics.geometry.pose2 import Pose2
from robotics.navigation.grid_map import GridMap
from robotics.navigation.route import Route, plan_route
from robotics.navigation.scan_matching import LikelihoodField
from robotics.navigation.unexpected import path_blocked, unexpected_points
from robotics.navigation.voronoi_graph import voronoi_graph

from .discrepancy import Discrepancy
from .world_model import ModelView

ROOM = 0.04  # [m] beside the footprint that a planned route keeps
SENSED_ROOM = 0.10  # [m] that what was sensed is grown by: its far side wasn't seen
WATCHED_ROOM = 0.015  # [m] beside the footprint that must be free while driving
REACH = 0.15  # [m] that start or goal may lie too close to something on the map
UNEXPLAINED = 0.12  # [m] from anything on the map: pose error, noise and half a cell together
HORIZON = 1.0  # [m] of route that is watched ahead


def plan_drive(robot: Robot, grid: GridMap, sensed: NDArray[np.float64], goal: Pose2) -> Route | None:
    """A route on the reduced generalized Voronoi graph, for the robot's footprint with arm and load.

    Args:
        robot: where it stands.
        grid: the map.
        sensed: (n, 2) points on the map that are to be kept away from as well, in [m].
        goal: map_T_base.
    """
    radius = robot.spec.footprint_radius_m + ROOM
    try:
        graph = voronoi_graph(
            grid.with_points(sensed, SENSED_ROOM), radius, seed_point=(robot.pose.x, robot.pose.y)
        )
    except ValueError:
        return None
    return plan_route(graph, robot.pose, goal, REACH)


def goal_pose(model: ModelView, place: str) -> Pose2:
    """map_T_base of a place; raises `Discrepancy` where the model has no such place."""
    if place not in model.places:
        raise Discrepancy(f"there is no place {place!r} on the map", permanent=True)
    return model.places[place].pose


class Lookout:
    """Watches a route for what the map doesn't show."""

    def __init__(self, grid: GridMap, radius: float) -> None:
        """For a robot whose footprint has `radius`, in [m]."""
        self._field = LikelihoodField(grid)
        self._radius = radius + WATCHED_ROOM

    def unexpected(self, robot: Robot) -> NDArray[np.float64]:
        """(n, 2) points of this period's scan that the map doesn't explain, on the map, in [m]."""
        points = robot.pose.apply(robot.range_sensor.scan().points())
        return unexpected_points(points, self._field, UNEXPLAINED)

    def obstacle(
        self, route: NDArray[np.float64], sensed: NDArray[np.float64]
    ) -> tuple[float, NDArray[np.float64]] | None:
        """How far the way is free, in [m], and the point (2,) in it; None if nothing is near."""
        return path_blocked(route, sensed, self._radius, HORIZON)
