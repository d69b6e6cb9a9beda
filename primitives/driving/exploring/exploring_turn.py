"""Turns on the spot, as far as the guard lets the base turn."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance
from handcart.robotics.navigation.following.sideways_tracking import make_tracker

TURN_TOLERANCE = PoseTolerance(position=0.10, heading=0.1)
TIMEOUT_S = 15.0
STILL_S = 1.0  # without turning on, from where the base counts as held
LEAST_RAD = 0.02  # of a turn in that time


def turn_by(robot: Robot, angle: float) -> Generator[None, None, bool]:
    """Turn the base on the spot by an angle in [rad], positive to the left.

    Returns:
        True if the base has turned by the full angle; False if it did not move for `STILL_S`, or needed more
        than `TIMEOUT_S`.
    """
    here = np.array([[robot.pose.x, robot.pose.y]])
    tracker = make_tracker(here, robot.pose.theta + angle, robot.drive_limits, tolerance=TURN_TOLERANCE)
    end, since, last = robot.time + TIMEOUT_S, robot.time, robot.pose
    while not tracker.finished(robot.pose):
        if last.turn(robot.pose) > LEAST_RAD:
            since, last = robot.time, robot.pose
        if robot.time > min(end, since + STILL_S):
            return False
        robot.base.drive(*tracker.command(robot.pose, robot.period))
        yield
    return True
