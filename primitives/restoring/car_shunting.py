"""Shunting a car that came back beside its start: a path forwards and backwards leads it there."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.description.ground_spec import OUTDOOR_LOCALIZERS
from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.bumps import avoided_points
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.car_tracker import CarTracker
from handcart.robotics.navigation.maps.point_discs import point_discs
from handcart.robotics.navigation.maps.rising_ground import may_be_ground
from handcart.robotics.navigation.routes.car_route import plan_car_route
from handcart.robotics.navigation.routes.tangent_path import CarPath
from handcart.robotics.numerics.arrays import FloatArray

from .snapshot import Snapshot, residuals, settle, take_snapshot_since_start

CAR_ROOM = 0.15  # [m] beside the footprint that a car's planned path keeps
ROCK_POSITION_TOLERANCE_M = 0.4  # error of a rock's believed position, mostly from the pose of the car
TURNING_RADIUS_RATIO = 1.05  # of the turning circle that the steering allows: planned with something in hand
MAX_SHUNTS = 3  # paths driven to one start
MIN_ROOM_M = 0.05  # a car does not stop more exactly than that
LONGEST_LOOK = 120.0  # [s] that a car waits until its pose is certain
LOOK_DURATION_S = 1.0  # of it at a time
SHUNT_STUCK_S = 6.0  # without progress along the path
PROGRESS_STEP_M = 0.01  # along the path, less is no progress


def known_discs(robot: Robot, model: ModelView | WorldModel) -> FloatArray:
    """Return known and sensed obstacles (n, 3) on the map: x, y and radius, in [m]."""
    rocks = model.discs
    known = rocks + np.array([0.0, 0.0, ROCK_POSITION_TOLERANCE_M]) if len(rocks) else rocks
    return np.vstack([known, point_discs(avoided_points(robot, model))])


def plan_car_drive(robot: Robot, start: Pose2, goal: Pose2, discs: FloatArray) -> CarPath | None:
    """Return a path on which a car can drive from one pose to another; None if none is found.

    Args:
        robot: the car.
        start: map_T_base at the start.
        goal: map_T_base at the end.
        discs: (n, 3) obstacles: x, y on the map and radius, in [m].
    """
    radius = TURNING_RADIUS_RATIO / robot.spec.drive.sharpest_per_m
    return plan_car_route(start, goal, discs, robot.spec.footprint_radius_m + CAR_ROOM, radius)


def bring_back(robot: Robot, start: Snapshot, model: WorldModel, room: float) -> Generator[None, None, None]:
    """Bring a car that is at rest next to its start pose to that pose by shunting, if a path is found.

    A car cannot move sideways. Before each path the car waits until its displacement since the start is
    known. The displacement is measured again because a gyro with an unknown bias leads a car back to a wrong
    place.

    Args:
        robot: car at rest.
        start: state of the robot as measured at the start.
        model: world model, with the obstacles to keep off.
        room: largest allowed distance of the base from its start, in [m]; if the tolerance in the robot's
            file is smaller, that tolerance is the limit.
    """
    for _ in range(MAX_SHUNTS):
        yield from _stand_until_sure(robot, start, room)
        if not _is_beside(robot, start, room):
            return
        here = _since_start(robot, start)
        discs = _discs_around(robot, model, here)
        path = yield from robot.compute(plan_car_drive, robot, here, start.pose, discs)
        if path is None or not (yield from _drive(robot, start, path)):
            return
        yield from settle(robot)
    yield from _stand_until_sure(robot, start, room)


def _stand_until_sure(robot: Robot, start: Snapshot, room: float) -> Generator[None, None, None]:
    end = robot.time + LONGEST_LOOK
    while robot.time < end and not _sure_of(robot, start, room):
        yield from robot.wait(LOOK_DURATION_S)


def _sure_of(robot: Robot, start: Snapshot, room: float) -> bool:
    found = residuals(start, take_snapshot_since_start(robot, {}), robot.spec, room)
    return all(residual.is_within for residual in found.all if residual.kind.is_uncertainty)


def _is_beside(robot: Robot, start: Snapshot, room: float) -> bool:
    """Return whether the base is measured off its start by more than allowed, and a path can change that."""
    found = residuals(start, take_snapshot_since_start(robot, {}), robot.spec, room)
    off = any(residual.kind.is_base_offset and not residual.is_within for residual in found.all)
    return off and room >= MIN_ROOM_M


def _since_start(robot: Robot, start: Snapshot) -> Pose2:
    """Return the pose of the base in the frame of its pose estimated at the start; errors common to both
    cancel.
    """
    moved = robot.localization.displacement
    return robot.pose if moved is None else start.pose.compose(Pose2(*moved.mean.tolist()))


def _discs_around(robot: Robot, model: WorldModel, here: Pose2) -> FloatArray:
    """Return known obstacles and those of this period's scan as discs (n, 3): x, y and radius in the frame of
    `here`, in [m].
    """
    known = known_discs(robot, model)
    known = np.column_stack([robot.pose.inverse().apply(known[:, :2]), known[:, 2]])
    points = robot.surroundings()
    if robot.spec.localizer in OUTDOOR_LOCALIZERS and len(points):
        points = points[~may_be_ground(points, robot.range_sensor_height, robot.localization.tilt)]
    around = np.vstack([known, point_discs(points)])
    return np.column_stack([here.apply(around[:, :2]), around[:, 2]])


def _drive(robot: Robot, start: Snapshot, path: CarPath) -> Generator[None, None, bool]:
    """Drive along a path to the start; return whether its end was reached."""
    here, sharpest = _since_start(robot, start), robot.spec.drive.sharpest_per_m
    tracker = CarTracker.along(path, here, start.pose, sharpest, robot.drive_limits)
    progress, since = 0.0, robot.time
    while not tracker.finished(here):
        robot.base.drive(*tracker.command(here, robot.period))
        yield
        here = _since_start(robot, start)
        if abs(tracker.progress - progress) > PROGRESS_STEP_M or robot.base.share_for_people < 1.0:
            progress, since = tracker.progress, robot.time
        if robot.time > since + SHUNT_STUCK_S:
            return False
    return True
