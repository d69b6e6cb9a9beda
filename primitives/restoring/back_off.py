"""Back off from an obstacle that the base ran into, before any other motion."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.blocked_motion import Blocked
from handcart.robotics.numerics.arrays import FloatArray

from .trace import Trace

STRAIGHT_M = 0.03  # more than the pose errs by: a base that turns while it touches something rubs along it
STRAIGHT_SPEED_M_S = 0.1
BACK_OFF_SPEED_M_S = 0.2
BACK_OFF_TIMEOUT_S = 20.0
SPACING_M = 0.01  # between poses of the way in: estimates tremble
LEAD_M = 0.1  # of way in which a wrong heading is corrected
MAX_CURVATURE_PER_M = 2.0


def back_off(robot: Robot, blocked: Blocked, trace: Trace) -> Generator[None, None, None]:
    """Drive back from the place where the base was stopped, along the path on which it came.

    The base first moves straight back by `STRAIGHT_M`, then with the headings of the path on which it came,
    until its footprint has left the place. The space that body and arm swept on that path is free, and a
    sharper turn would sweep more. All distances are from the place where the base was stopped, so a rebound
    from the obstacle is part of them.

    Args:
        robot: robot at rest.
        blocked: place where the base was stopped, and the base's motion there.
        trace: record of the motion to that place.
    """
    way, headings = _way_in(trace, blocked, 2.0 * robot.spec.footprint_radius_m)
    length, end = max(STRAIGHT_M, float(way[-1])), robot.time + BACK_OFF_TIMEOUT_S
    limits, speed = robot.drive_limits, 0.0
    while (away := _away(robot, blocked)) < length and robot.time < end:
        allowed = STRAIGHT_SPEED_M_S if away < STRAIGHT_M else BACK_OFF_SPEED_M_S
        speed = min(speed + limits.acceleration * robot.period, allowed, limits.speed)
        bend = 0.0
        if away >= STRAIGHT_M:
            wanted = float(np.interp(away + LEAD_M, way, headings))
            now = robot.localization.odometry_pose.theta + blocked.direction
            bend = wrap(wanted - now) / LEAD_M
        turn_rate = min(MAX_CURVATURE_PER_M, max(-MAX_CURVATURE_PER_M, bend)) * speed
        along = -speed if blocked.forwards else speed
        robot.base.drive(*DriveCommand.towards(blocked.direction, along, turn_rate))
        yield


def _away(robot: Robot, blocked: Blocked) -> float:
    """Return the base's distance from where it was stopped, in [m]; negative if it is ahead in that
    motion.
    """
    pose = robot.localization.odometry_pose
    ahead = blocked.pose.inverse().compose(pose).x * (1.0 if blocked.forwards else -1.0)
    return math.copysign(pose.distance(blocked.pose), -ahead)


def _way_in(trace: Trace, blocked: Blocked, length: float) -> tuple[FloatArray, FloatArray]:
    """Return distances (n,) in [m] back along the way from where the base was stopped, and headings (n,) in
    [rad].

    They end at `length`, in [m], or where the base last came from the other side, or turned without driving.
    """
    moments = trace.moments[: trace.nearest(blocked.pose) + 1]
    turned = Pose2(0.0, 0.0, blocked.direction)
    poses = [(moment.odometry_pose or moment.pose).compose(turned) for moment in reversed(moments)]
    distances, headings, last = [0.0], [poses[0].theta], poses[0]
    for pose in poses[1:]:
        step = pose.distance(last)
        if step < SPACING_M:
            continue
        ahead = last.relative_to(pose).x
        if (ahead > 0.0) != blocked.forwards or distances[-1] + step > length:
            break
        distances.append(distances[-1] + step)
        headings.append(headings[-1] + math.remainder(pose.theta - headings[-1], math.tau))
        last = pose
    return np.array(distances), np.array(headings)
