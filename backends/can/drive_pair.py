"""The drives of both wheels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from backends.can_spec import CanSpec
from backends.robot_file import RobotFile

from .can_line import CanLine
from .drive_setup import set_up
from .errors import DriveNotReady
from .wheel_drive import ENABLED, FAULT, WheelDrive

_TO_ENABLE = 20  # periods within which a drive is to become ready
_QUICKER = 2.0  # than usual slowing down: a quick stop
_ANSWER_WITHIN = 0.5  # share of a period


class Speeds(NamedTuple):
    """Of the wheels' rims, forward positive."""

    left: float
    """[m/s]"""
    right: float
    """[m/s]"""


STILL = Speeds(0.0, 0.0)


class DrivePair:
    """Two drives that move and stop together: what goes wrong with one stops both."""

    def __init__(self, robot: RobotFile, spec: CanSpec) -> None:
        """Drives by a robot's file and its section `can`; nothing is sent yet.

        Raises:
            TooManyCounts: a wheel's speed or acceleration doesn't fit into 32 bits.
        """
        self._period = robot.period_s
        self._acceleration = rim_acceleration(robot)
        self._braking = _QUICKER * self._acceleration
        self._to_rest = 2 + round(rim_speed(robot) / self._braking / self._period)
        most, radius = max(rim_speed(robot), self._braking), robot.drive.wheel_radius_m
        self._both = tuple(
            WheelDrive(name, each, radius, most)
            for name, each in zip(("left", "right"), spec.wheels, strict=True)
        )
        self.left, self.right = self._both

    def start(self, line: CanLine, pace: Callable[[], None]) -> None:
        """Set the drives up, and enable them.

        Args:
            line: to the drives.
            pace: waits for the end of the period.

        Raises:
            CanFault: a drive is missing, is of a wrong kind, or doesn't become ready.
            can.CanError: of the interface.
        """
        self._line, self._pace = line, pace
        for drive in self._both:
            line.add_node(drive)
        for drive in self._both:
            set_up(drive, self._period, self._acceleration, self._braking)
        for _ in range(_TO_ENABLE):
            self._sync()
            for drive in self._both:
                drive.check_answered(self._period)
                if drive.drive_state == FAULT:
                    raise DriveNotReady(drive.name, FAULT, drive.fault)
            if all(drive.drive_state == ENABLED and drive.stands for drive in self._both):
                break
            for drive in self._both:
                drive.towards_enabled()
        for drive in self._both:
            drive.check(self._period)
            drive.rezero()

    def send(self, speeds: Speeds) -> None:
        """Command both wheels; takes effect at once."""
        for drive, speed in zip(self._both, speeds, strict=True):
            drive.drive(speed)

    def end_period(self) -> None:
        """Wait for the end of the period, and for what the drives say of it.

        Raises:
            CanFault: a drive is silent or not enabled.
            can.CanError: of the interface.
        """
        self._sync()
        for drive in self._both:
            drive.check(self._period)

    def let_go(self) -> None:
        """Bring both to rest by a quick stop, then take their torque away.

        A drive that doesn't answer gets the time that it needs.
        """
        for drive in self._both:
            drive.quick_stop()
        for _ in range(self._to_rest):
            if all(drive.answered and drive.stands for drive in self._both):
                break
            self._sync()
        for drive in self._both:
            drive.disable()

    def _sync(self) -> None:
        self._pace()
        self._line.drain()  # what is late belongs to an earlier SYNC
        for drive in self._both:
            drive.ask()
        self._line.sync.transmit()
        self._line.wait(lambda: all(drive.answered for drive in self._both), _ANSWER_WITHIN * self._period)


def rim_speed(robot: RobotFile) -> float:
    """The most that a wheel's rim ever has to run, in [m/s]."""
    drive = robot.drive
    return drive.top_speed_m_s + math.radians(drive.top_turn_deg_s) * drive.tread_m / 2


def rim_acceleration(robot: RobotFile) -> float:
    """The most by which a wheel's rim ever has to speed up, in [m/s²]."""
    drive = robot.drive
    return drive.acceleration_m_s2 + math.radians(drive.turn_acceleration_deg_s2) * drive.tread_m / 2
