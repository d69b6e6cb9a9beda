"""Straight drives away from obstacles that hold the base."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.drive_limits import Ramp
from handcart.robotics.navigation.following.sideways_motion import SidewaysRamp

PINNED_MOTION_M = 0.05  # within which a position is one place
PINNED_TURN_RAD = 0.05  # beyond the headings that the base had there, from which it turns to new ones
PINNED_S = 0.8  # that the guard holds the base at about one place, until it backs off
BACK_OFF_M, BACK_OFF_SPEED_M_S = 0.25, 0.15
BACK_OFF_TIMEOUT_S = 3.0  # without the time to reach the speed
BACK_OFF_MAX_TRIES = 8


class PinnedWatch:
    """Watch for a base that the guard holds at one place, with how long it was held there.

    A base that turns to new headings gets on, for example out of a corner. One that turns to and fro does
    not.
    """

    def __init__(self, pose: Pose2) -> None:
        """Begin at a pose map_T_base."""
        self.restart(pose)

    def restart(self, pose: Pose2) -> None:
        """Begin again at a pose map_T_base, before the base was held."""
        self._anchor, self._low, self._high, self._held_s = pose, 0.0, 0.0, 0.0

    def note(self, robot: Robot, waits: bool) -> None:
        """Note a period, in which the base may wait on purpose."""
        turned = wrap(robot.pose.theta - self._anchor.theta)
        turns = turned > self._high + PINNED_TURN_RAD or turned < self._low - PINNED_TURN_RAD
        guarded = turns and not robot.spec.footprint_shape.is_disc  # it turns where there is room alone
        if waits or guarded or robot.pose.distance(self._anchor) > PINNED_MOTION_M:
            self.restart(robot.pose)
        elif turns:
            self._low, self._high = min(self._low, turned), max(self._high, turned)
            self._held_s = 0.0
        elif robot.held is not None:
            self._held_s += robot.period

    @property
    def is_held(self) -> bool:
        """True if the guard has held the base at this place and heading."""
        return self._held_s > 0.0

    @property
    def is_pinned(self) -> bool:
        """True if the guard has held the base for more than `PINNED_S` in total."""
        return self._held_s > PINNED_S


class BackingOff:
    """Straight drives away from what holds the base, within the limits of its acceleration."""

    def __init__(self) -> None:
        self.tries = 0
        """Number of drives since the base last got nearer to its goal."""
        self._stuck_way = 0.0

    @property
    def may_try(self) -> bool:
        """True until `BACK_OFF_MAX_TRIES` drives."""
        return self.tries < BACK_OFF_MAX_TRIES

    def drive(self, robot: Robot, reverse: bool) -> Generator[None, None, None]:
        """Drive straight away from the obstacle that holds the base, and come to rest.

        A base with a circular footprint reverses its last direction. A base with a polygonal footprint drives
        forwards if the obstacle is near its rear, and backwards if the obstacle is near its front. If the
        last attempt failed, it drives in the opposite direction.

        Args:
            robot: the robot.
            reverse: True if the base drove backwards.
        """
        self.tries += 1
        start, sign = robot.pose, self._way_off(robot, reverse)
        is_disc = robot.spec.footprint_shape.is_disc
        yield from (_drive_straight if is_disc else _drive_at_once)(robot, _away_from(robot, sign))
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


def _drive_straight(robot: Robot, top: DriveCommand) -> Generator[None, None, None]:
    """Drive `BACK_OFF_M` with up to the speed of a command, and come to rest.

    The drive is shorter if something holds the base in the direction of the command. While the base still
    rolls in its earlier direction, it slows down, whatever holds it there. The commands change within the
    limits of the base's acceleration.
    """
    limits, dt, command = robot.drive_limits, robot.period, robot.command
    ramp, leaves, brakes = _ramp_from(robot, command), False, False
    start, end = robot.pose, robot.time + BACK_OFF_TIMEOUT_S + abs(top.along) / limits.acceleration
    while not (brakes and ramp.at_rest):
        stop = abs(command.along) * dt + command.along**2 / (2.0 * limits.acceleration)
        leaves = leaves or command.speed * top.speed + command.sideways * top.sideways > 0.0
        far = leaves and robot.pose.distance(start) + stop >= BACK_OFF_M
        brakes = brakes or far or robot.time >= end
        wanted = DriveCommand() if brakes else top
        sideways = (wanted.sideways,) if isinstance(ramp, SidewaysRamp) else ()
        command = DriveCommand(*ramp.towards(wanted.speed, 0.0, dt, *sideways))
        robot.base.drive(*command)
        yield
        brakes = brakes or (leaves and robot.held is not None)


def _drive_at_once(robot: Robot, command: DriveCommand) -> Generator[None, None, None]:
    """Drive `BACK_OFF_M` with a command from the first period on, less far if something holds the base.

    Polygons leave that way: after slow starts and stops, a husky did not find back to its start any more.
    """
    start, end = robot.pose, robot.time + BACK_OFF_TIMEOUT_S
    while robot.pose.distance(start) < BACK_OFF_M and robot.time < end:
        robot.base.drive(*command)
        yield
        if robot.held is not None:
            break


def _ramp_from(robot: Robot, command: DriveCommand) -> Ramp:
    """Return a limiter of the commands of the robot's base that begins with a command."""
    limits = robot.drive_limits
    if robot.spec.drive.kind == "holonomic":
        ramp: Ramp = SidewaysRamp(limits, command.sideways)
    else:
        ramp = Ramp(limits)
    ramp.speed, ramp.turn_rate = command.speed, command.turn_rate
    return ramp


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
