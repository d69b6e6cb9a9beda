"""Straight drives away from obstacles that hold the base."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.robot.robot import Robot

PINNED_MOTION_M = 0.05  # within which a position is one place
BACK_OFF_M, BACK_OFF_SPEED_M_S = 0.25, 0.15
BACK_OFF_TIMEOUT_S = 3.0
BACK_OFF_MAX_TRIES = 8


class BackingOff:
    """Straight drives away from what holds the base, and the number of them."""

    def __init__(self) -> None:
        self.tries = 0
        """Number of drives since the base last got nearer to its goal."""
        self._stuck_way = 0.0

    @property
    def may_try(self) -> bool:
        """True until `BACK_OFF_MAX_TRIES` drives."""
        return self.tries < BACK_OFF_MAX_TRIES

    def drive(self, robot: Robot, reverse: bool) -> Generator[None, None, None]:
        """Drive straight away from the obstacle that holds the base.

        A base with a circular footprint reverses its last direction. A base with a polygonal footprint drives
        forwards if the obstacle is near its rear, and backwards if the obstacle is near its front. If the
        last attempt failed, it drives in the opposite direction.

        Args:
            robot: the robot.
            reverse: True if the base drove backwards.
        """
        self.tries += 1
        start, sign = robot.pose, self._way_off(robot, reverse)
        yield from _drive_straight(robot, _away_from(robot, sign))
        if robot.pose.distance(start) < PINNED_MOTION_M:
            self._stuck_way = sign

    def _way_off(self, robot: Robot, reverse: bool) -> float:
        """Return 1 if the base should leave forwards from what holds it, -1 backwards."""
        if robot.held is None or robot.spec.footprint_shape.is_disc:
            return 1.0 if reverse else -1.0
        ahead = robot.pose.inverse().apply(np.array([[robot.held.x, robot.held.y]]))[0, 0]
        sign = -1.0 if ahead > 0.0 else 1.0
        sign = -sign if sign == self._stuck_way else sign
        self._stuck_way = 0.0
        return sign


def _drive_straight(robot: Robot, command: DriveCommand) -> Generator[None, None, None]:
    """Drive `BACK_OFF_M` with a command, less far if something holds the base."""
    start, end = robot.pose, robot.time + BACK_OFF_TIMEOUT_S
    while robot.pose.distance(start) < BACK_OFF_M and robot.time < end:
        robot.base.drive(*command)
        yield
        if robot.held is not None:
            break


def _away_from(robot: Robot, sign: float) -> DriveCommand:
    """Return the command away from what holds the base: backwards, or any direction if holonomic.

    `sign` is 1 for a base whose rear led.
    """
    held = robot.held
    if robot.spec.drive.kind != "holonomic" or held is None:
        return DriveCommand(sign * BACK_OFF_SPEED_M_S)
    x, y = robot.pose.inverse().apply(np.array([[held.x, held.y]]))[0].tolist()
    most = min(BACK_OFF_SPEED_M_S, robot.drive_limits.sideways)
    return DriveCommand.towards(math.atan2(-y, -x), most, 0.0)
