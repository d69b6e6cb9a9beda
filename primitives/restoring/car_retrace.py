"""Playing the recorded motion of a car backwards: it can only go back along its own track."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from itertools import pairwise

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.car_tracker import CarTracker

from .arm_command import command_moment, renew_passed
from .pauses import Pauses
from .return_progress import ReturnProgress
from .snapshot import Snapshot
from .trace import Moment, Trace

MIN_ROLL_M = 1e-5  # between two periods, less is not motion
CAR_POINT_SPACING_M = 0.05  # between points of the way back
MIN_STRETCH_M = 0.10  # a way that is not worth driving back
FINAL_SPEED_M_S = 0.1  # straight on, in the end


def car_retrace(robot: Robot, start: Snapshot, trace: Trace) -> Generator[None, None, None]:
    """Bring a car back to the snapshot along the path on which it came, and arm and gripper with it.

    The car is steered by `Localization.odometry_pose`, because this pose does not jump and is the best
    estimate over the length of an action. Whether the car came back is measured afterwards.
    """
    for stretch in reversed(_stretches(trace.moments)):
        forward = _forward(stretch[0], stretch[-1])
        if abs(forward) < MIN_STRETCH_M:
            for moment in reversed(stretch):
                yield from command_moment(robot, moment)
        else:
            yield from _drive_back(robot, stretch, forward > 0.0)
    yield from _straight_to(robot, start)
    yield from command_moment(robot, Moment(start.pose, start.joint_command, start.gripper_command))


def _straight_to(robot: Robot, start: Snapshot) -> Generator[None, None, None]:
    """Drive straight by the distance to the start; otherwise short remainders would add up."""
    came = robot.localization.displacement
    begin = start.pose.relative_to(robot.pose)
    left = begin.x if came is None else Pose2(*came.mean.tolist()).inverse().x
    if abs(left) < MIN_STRETCH_M:
        return
    begun, getting_on = robot.localization.odometry_pose, ReturnProgress(robot)
    while (driven := abs(robot.localization.odometry_pose.relative_to(begun).x)) < abs(
        left
    ) - FINAL_SPEED_M_S * robot.period:
        getting_on.check(driven)
        robot.base.drive(math.copysign(FINAL_SPEED_M_S, left), 0.0)
        yield


def check_stands(robot: Robot, goal: Pose2) -> None:
    """Raise `Discrepancy` if a car is not at a pose within the tolerance of the robot's file.

    No motion is tried, because a car cannot move sideways.
    """
    off, most = robot.pose.distance(goal), robot.spec.tolerance.base_mm / 1e3
    turned = math.degrees(robot.pose.turn(goal))
    if exceeds(off, most) or exceeds(turned, robot.spec.tolerance.base_deg):
        away = Measured("Base", "distance from its goal", off, most, "m")
        raise Discrepancy("the car doesn't reach its pose", measured=away, cause=causes.OFF_GOAL)


def _reckoned(moment: Moment) -> Pose2:
    return moment.odometry_pose if moment.odometry_pose is not None else moment.pose


def _forward(before: Moment, after: Moment) -> float:
    """Return the way from one moment to the other, in [m]; negative if backwards."""
    moved = _reckoned(after).relative_to(_reckoned(before))
    return math.copysign(math.hypot(moved.x, moved.y), moved.x)


def _stretches(moments: Sequence[Moment]) -> list[list[Moment]]:
    """Divide the moments where the car rests or changes its direction."""
    result: list[list[Moment]] = []
    direction = 0
    for before, now in pairwise(moments):
        rolled = _reckoned(now).relative_to(_reckoned(before)).x
        moves = 0 if abs(rolled) < MIN_ROLL_M else int(math.copysign(1, rolled))
        if not result or moves != direction:
            result.append([before])
        result[-1].append(now)
        direction = moves
    return result or [list(moments)]


def _drive_back(robot: Robot, stretch: Sequence[Moment], forwards: bool) -> Generator[None, None, None]:
    """Drive back along a stretch that was driven in one direction, the arm as it was at each place."""
    left = list(stretch)
    poses, along = [_reckoned(left[-1])], [0.0]
    for before, now in pairwise(reversed(left)):
        along.append(along[-1] + _reckoned(now).distance(_reckoned(before)))
        if _reckoned(now).distance(poses[-1]) >= CAR_POINT_SPACING_M:
            poses.append(_reckoned(now))
    sharpest = robot.spec.drive.sharpest_per_m
    tracker = CarTracker([(np.array(poses), forwards)], sharpest, robot.drive_limits)
    pauses, getting_on = Pauses(robot), ReturnProgress(robot)
    while not tracker.finished(robot.localization.odometry_pose):
        if pauses.has_ended():
            tracker.stopped()
        getting_on.check(tracker.progress)
        robot.base.drive(*tracker.command(robot.localization.odometry_pose, robot.period))
        renew_passed(robot, left, along[::-1], tracker.progress)
        yield
    for moment in reversed(left):
        yield from command_moment(robot, moment)
