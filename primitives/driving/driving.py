"""Common parts of MOVE_TO and MODIFY: planning a drive, and detecting obstacles on the route."""

from __future__ import annotations

from collections.abc import Generator
from functools import cached_property

import numpy as np

from handcart.backends.description.ground_spec import OUTDOOR_LOCALIZERS
from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.bumps import avoided_points
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.restoring.car_shunting import known_discs, plan_car_drive
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.car_tracker import CarTracker
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance
from handcart.robotics.navigation.following.sideways_tracking import make_tracker
from handcart.robotics.navigation.following.way_guard import HoldingObstacle
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.rising_ground import may_be_ground
from handcart.robotics.navigation.maps.scan_layer import ScanLayer
from handcart.robotics.navigation.routes.ways import Way, Ways
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField
from handcart.robotics.navigation.scans.unexpected import path_blocked, unexpected_points
from handcart.robotics.numerics.arrays import FloatArray

WATCHED_ROOM = 0.015  # [m] beside the footprint that must be free while driving
MAP_MATCH_TOLERANCE_M = 0.12  # from anything on the map: pose error, noise and half a cell together
BESIDE_IT = 0.6  # [m] around the base's possible contacts, in which the scan is remembered
LEAST_OFF = 0.05  # [m] from a wall of the map at which a scan shows something other than the wall
WATCH_HORIZON_M = 1.0  # of route that is watched ahead
OBSTACLE_MEMORY_RADIUS_M = 2.5  # around an obstacle in a car's way, in which readings are remembered


def plan_drive(robot: Robot, model: ModelView, goal: Place, cells: bool = True) -> Way:
    """Plan a route to a place on the reduced generalized Voronoi graph, with the footprint of arm and load.

    The route avoids everything on the map, and the world model's sensed obstacles and bumps. If no route is
    found, the result holds the reason.

    Args:
        robot: the robot, whose current pose is the start.
        model: the world model.
        goal: the place.
        cells: True to avoid map cells in which the lidar has recently seen something, too.
    """
    grid = map_with_cells(model) if cells else model.map
    ways = Ways(grid, robot.spec.footprint_shape, robot.pose, avoided_points(robot, model))
    return ways.to(goal.pose, goal.front if goal.docks else None)


def map_with_cells(model: ModelView) -> GridMap:
    """Return the map, where cells with unmapped obstacles that the lidar has recently sensed are occupied."""
    if not len(model.sensed_cells):
        return model.map
    layer = ScanLayer(model.map)
    layer.restore(model.sensed_cells)
    return layer.merged()


def no_way(name: str, way: Way) -> Discrepancy:
    """Return a `Discrepancy` with the reason why no route leads to a place; a new attempt would not help.

    Args:
        name: name of the place.
        way: result of the planning, with the reason.
    """
    words = f"no way leads to {name}" if way.fits else f"the base can't stand at {name}"
    return Discrepancy(
        f"{words}: {way.reason}", permanent=True, measured=_shortage(way), cause=causes.NO_ROUTE
    )


def held_before(place: str, held: HoldingObstacle) -> Discrepancy:
    """Return a `Discrepancy` whose reason is that an obstacle has stopped the base on its way to a place.

    Args:
        place: name of the place.
        held: obstacle before which the guard, which prevents collisions, has stopped the base.
    """
    shown = (
        "ground that the lidar does not see"
        if held.shown_by == "unseen"
        else f"what the {held.shown_by} shows"
    )
    sensor = "Base" if held.shown_by == "contact" else "RangeSensor"
    near = Measured(sensor, f"room to {shown}", held.room, held.needed, "m")
    return Discrepancy(
        f"the base doesn't get on to {place}: {held.words}", measured=near, cause=causes.BLOCKED
    )


def _shortage(way: Way) -> Measured | None:
    """Return the clearance or width that was too small for a route, as a reading with its limit; None if none
    was.
    """
    if not way.fits:
        return Measured("Base", "from the place to what is nearest", way.clearance, way.needed, "m")
    return Measured("Base", "width of the way", way.width, way.width_needed, "m") if way.narrow else None


def plan_tracker(
    robot: Robot, model: ModelView, place: str, goal: Pose2, tolerance: PoseTolerance, reverse: bool = False
) -> Generator[None, None, tuple[PathTracker | CarTracker, FloatArray]]:
    """Return a tracker for a route to a place, and the route's points (n, 2) on the map, in [m].

    The route is the detour around an obstacle that the world model holds for this place, otherwise a new
    route on the map. A car always gets a new route from its current pose, past known and sensed obstacles.

    Args:
        robot: robot at the start of the route.
        model: world model.
        place: name of the place.
        goal: map_T_base at the end of the route.
        tolerance: tolerance of the pose at the end.
        reverse: True to drive with the rear ahead, which a car can't.

    Raises:
        Discrepancy: no route was found, or a car would have to reverse.
    """
    if robot.spec.drive.kind == "ackermann":
        if reverse:
            raise Discrepancy(
                "a car-like base isn't driven backwards", permanent=True, cause=causes.UNSUITABLE
            )
        way = yield from robot.compute(plan_car_drive, robot, robot.pose, goal, known_discs(robot, model))
        if way is None:
            raise Discrepancy(f"no way leads to {place} in the field", permanent=True, cause=causes.NO_ROUTE)
        sharpest = robot.spec.drive.sharpest_per_m
        tracker = CarTracker.along(way, robot.pose, goal, sharpest, robot.drive_limits)
        return tracker, way.poses[:, :2]
    if model.detour and model.detour.goal == place:
        points = model.detour.points
    else:
        found = yield from robot.compute(plan_drive, robot, model, model.places[place])
        if found.route is None:
            raise no_way(place, found)
        points = found.route.points
    return make_tracker(
        points, goal.theta, robot.drive_limits, reverse, tolerance, model.speed_limits
    ), points


def goal_pose(model: ModelView, place: str) -> Pose2:
    """Return map_T_base of a place; raises `Discrepancy` if the model has no such place."""
    if place not in model.places:
        raise Discrepancy(f"unknown place {place!r} on the map", permanent=True, cause=causes.NOT_KNOWN)
    return model.places[place].pose


def make_monitor(robot: Robot, model: ModelView) -> ObstacleMonitor | FieldObstacleMonitor:
    """Return a monitor that detects obstacles on the route, suited to the robot's kind of base."""
    if robot.spec.drive.kind == "ackermann":
        return FieldObstacleMonitor(robot.spec.footprint_radius_m)
    return ObstacleMonitor(model.map, robot.spec.footprint_shape.inscribed)


class FieldObstacleMonitor:
    """Monitor that watches a car's path for obstacles, on the map or not, because outdoor maps are
    inexact.
    """

    def __init__(self, radius: float) -> None:
        """Watch for a footprint of `radius`, in [m]."""
        self._radius = radius + WATCHED_ROOM

    def unexpected(self, robot: Robot) -> FloatArray:
        """Return the points (n, 2) of this period's scan that may be obstacles, in the field's frame, in [m].

        Points of the robot's own lowered hand, and points that may be the ground, are left out. If a point
        that may be the ground is an obstacle, the base's collision guard stops the base near it.
        """
        points = robot.without_hand(robot.range_sensor.scan().points())
        if robot.spec.localizer in OUTDOOR_LOCALIZERS:
            points = points[~may_be_ground(points, robot.range_sensor_height, robot.localization.tilt)]
        return robot.pose.apply(points)

    def kept(self, sensed: FloatArray, blocking: FloatArray) -> FloatArray:
        """Return the points (m, 2) to remember as obstacles, within `OBSTACLE_MEMORY_RADIUS_M` of `blocking`.

        Args:
            sensed: (n, 2) points that may be obstacles, in the field's frame, in [m].
            blocking: (2,) point of an obstacle on the route, in the same frame, in [m].
        """
        return np.asarray(sensed[np.hypot(*(sensed - blocking).T) < OBSTACLE_MEMORY_RADIUS_M])

    def around(self, robot: Robot, blocking: FloatArray) -> FloatArray:
        """Return the points (n, 2) of the obstacle to which the point `blocking` (2,) on the car's path
        belongs.

        The result is `blocking` itself and the points near it in this period's scan that may be obstacles;
        all are in the field's frame, in [m].
        """
        return np.vstack([blocking, self.kept(self.unexpected(robot), blocking)])

    def obstacle(self, route: FloatArray, sensed: FloatArray) -> tuple[float, FloatArray] | None:
        """Return the free distance along a route, in [m], and the obstacle's point (2,); None if the route is
        free.

        Args:
            route: (n, 2) in the field's frame, in [m].
            sensed: (m, 2) points that may be obstacles, in the same frame, in [m], as is the point returned.
        """
        return path_blocked(route, sensed, self._radius, WATCH_HORIZON_M)


class ObstacleMonitor:
    """Monitor of a route for obstacles that the map doesn't show."""

    def __init__(self, grid: GridMap, radius: float) -> None:
        """Watch for a footprint of `radius`, in [m]."""
        self._grid, self._radius = grid, radius + WATCHED_ROOM

    @cached_property
    def _field(self) -> LikelihoodField:
        """Distances to what the map shows; large maps take their time, so only once it is asked for."""
        return LikelihoodField(self._grid)

    def unexpected(self, robot: Robot) -> FloatArray:
        """Return the points (n, 2), on the map in [m], where this period's scan hit something not on
        the map.
        """
        points = robot.pose.apply(robot.range_sensor.scan().points())
        return unexpected_points(points, self._field, MAP_MATCH_TOLERANCE_M)

    def kept(self, sensed: FloatArray, blocking: FloatArray) -> FloatArray:
        """Return the sensed points to remember as obstacles, which are all of them.

        Args:
            sensed: (n, 2) points that the map does not explain, on the map, in [m].
            blocking: (2,) point of an obstacle on the route, on the map, in [m]; not used.
        """
        return sensed

    def around(self, robot: Robot, blocking: FloatArray) -> FloatArray:
        """Return the points (n, 2) of an obstacle near `blocking`, the point (2,) that the base would touch.

        The result is that point and the points near it in this period's scan, all on the map, in [m]. Points
        within a cell of a mapped wall are taken for the wall, and left out.
        """
        points = robot.pose.apply(robot.surroundings())
        near = points[np.hypot(*(points - blocking).T) < BESIDE_IT]
        before = near[self._field.read(near) > max(LEAST_OFF, self._field.map.resolution)]
        return np.vstack([blocking, before])

    def obstacle(self, route: FloatArray, sensed: FloatArray) -> tuple[float, FloatArray] | None:
        """Return the free distance along a route, in [m], and the obstacle's point (2,); None if the route is
        free.

        Args:
            route: (n, 2) on the map, in [m].
            sensed: (m, 2) points that may be obstacles, on the map, in [m], as is the point returned.
        """
        return path_blocked(route, sensed, self._radius, WATCH_HORIZON_M)
