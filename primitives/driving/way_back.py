"""The drive back to where MOVE_TO began, when something stands on the route by which the base came."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.sideways_tracking import make_tracker
from handcart.robotics.navigation.routes.replanning import RouteLook
from handcart.robotics.numerics.arrays import FloatArray

from .local_replanning import HOLD_DISTANCE_M, LOOK_PERIOD_S, LocalReplanning

OVERLAP_M = 0.06  # by which sensed cells may reach into the way that the base came: they are squares
PERSON_WAIT_S = 15.0  # minimum time to wait for a person on the way back


def way_back_blocked(local: LocalReplanning, robot: Robot, ahead: FloatArray) -> bool:
    """Return whether an obstacle is on the first `HOLD_DISTANCE_M` of the recorded route back.

    Args:
        local: replanning of the drive's routes, with the obstacles that the robot has sensed.
        robot: the robot.
        ahead: (n, 2) points of the way back, from the robot's present position on, on the map, in [m].
    """
    if len(ahead) < 2:
        return False
    near = np.cumsum(np.hypot(*np.diff(ahead, axis=0, prepend=ahead[:1]).T)) < HOLD_DISTANCE_M
    least = robot.spec.footprint_shape.inscribed - OVERLAP_M
    return local.free_length(ahead[near], least) is not None


def brake(robot: Robot) -> None:
    """Command the base to slow down within its limits until it is at rest; called once a period.

    A car stays on its arc.
    """
    last, limits = robot.command, robot.drive_limits
    along = max(0.0, abs(last.along) - limits.acceleration * robot.period)
    if robot.spec.drive.kind == "ackermann":
        turn_rate = last.turn_rate * along / abs(last.along) if last.along else 0.0
    else:
        rest = max(0.0, abs(last.turn_rate) - limits.turn_acceleration * robot.period)
        turn_rate = math.copysign(rest, last.turn_rate)
    robot.base.drive(*DriveCommand.towards(last.direction, math.copysign(along, last.along), turn_rate))


def drive_back(
    local: LocalReplanning, robot: Robot, goal: Pose2, wait_s: float
) -> Generator[None, None, None]:
    """Drive back to the start pose `goal`, map_T_base, by a route that is free now.

    Args:
        local: planner of routes around obstacles, with the obstacles sensed in this drive.
        robot: the robot.
        goal: pose of the base where the drive began, map_T_base.
        wait_s: time in [s] to wait for a route; people get more time to leave.

    Raises:
        Discrepancy: no route has led to the goal for `wait_s`, or longer if people are in the way.
    """
    local.turn_to(goal, robot)
    look = yield from _first_route(local, robot, wait_s)
    tracker = make_tracker(look.points, goal.theta, robot.drive_limits, allowed=look.speeds)
    while not tracker.finished(robot.pose):
        local.update(robot, tracker)
        since = local.waits_since
        if since is not None and robot.time > since + _patience(local, wait_s):
            raise _blocked()
        if local.pinned(robot):
            yield from local.back_off(robot, tracker)
        robot.base.drive(*local.command(robot, tracker))
        yield


def _first_route(local: LocalReplanning, robot: Robot, wait_s: float) -> Generator[None, None, RouteLook]:
    """Plan until a route is found, while the base holds; raise `Discrepancy` after the time for waiting."""
    since = robot.time
    while True:
        look = yield from local.planned(robot)
        if look.kind != "none":
            return look
        if robot.time > since + _patience(local, wait_s):
            raise _blocked()
        yield from robot.wait(LOOK_PERIOD_S)


def _patience(local: LocalReplanning, wait_s: float) -> float:
    """Return how long in [s] the base waits: `wait_s`, or longer while people are seen."""
    return max(wait_s, PERSON_WAIT_S) if local.people.sees_people else wait_s


def _blocked() -> Discrepancy:
    return Discrepancy("an obstacle is on the way back, and no other way leads there", cause=causes.BLOCKED)
