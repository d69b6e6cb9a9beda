"""The base, by ROS 2: speeds out, odometry in."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from typing_extensions import override

from handcart.backends.capabilities.base import Base, DriveCommand, HolonomicBase, WheelTravel
from handcart.backends.description.robot_file import Drive
from handcart.backends.description.ros_spec import RosOdometrySpec
from handcart.backends.limits import checked_command
from handcart.backends.plain_values import Kinds
from handcart.robotics.geometry.pose2 import Pose2

from .wire.alternation import AlternationWatch
from .wire.topic_sensor import TopicSensor

MAX_ALTERNATION_M, MAX_ALTERNATION_DEG = 0.01, 1.0
"""Deviation of a pose from the poses before and after it up to which one node may have sent all of them."""


class OdometryTopic(TopicSensor):
    """Receiver of `nav_msgs/Odometry`, which converts the poses in the messages to travel of the wheels.

    Only differences of poses are used, so the start of the odometry does not matter.
    """

    KIND = "nav_msgs/Odometry"
    STATE: ClassVar[Kinds] = {"travel": WheelTravel, "_last": tuple[float, Pose2] | None}
    travel = WheelTravel(0.0, 0.0)
    """Travel of the wheels since the first message, in [m]."""
    jumped = ""
    """Distance by which the odometry jumped, or by which its poses alternate, as text; "" if they do not."""

    def fit(self, drive: Drive, limits: RosOdometrySpec = RosOdometrySpec()) -> None:
        """Set drive and limits, before the first message arrives.

        Args:
            drive: drive of the robot, to convert motion to wheel travel.
            limits: largest plausible motion between two messages; a larger one is a jump of the odometry.
        """
        self._drive, self._limits = drive, limits
        self._last: tuple[float, Pose2] | None = None
        turn = math.radians(MAX_ALTERNATION_DEG)
        self._alternation = AlternationWatch((MAX_ALTERNATION_M, MAX_ALTERNATION_M, turn))
        self._heading = 0.0

    @property
    def pose(self) -> Pose2 | None:
        """Last 2D pose of the base in the odometry frame; None before the first message."""
        return None if self._last is None else self._last[1]

    @override
    def _shift_stamps(self, step_s: float) -> None:
        super()._shift_stamps(step_s)
        self._alternation.forget()
        if self._last is not None:
            self._last = self._last[0] + step_s, self._last[1]

    @override
    def forget(self) -> None:
        super().forget()
        self._alternation.forget()

    @override
    def _wrong(self, message: Any) -> str:
        pose = message.pose.pose
        numbers = [pose.position.x, pose.position.y, *_quaternion(pose.orientation)]
        if not all(map(math.isfinite, numbers)):
            return "its pose is not finite"
        norm = math.hypot(*_quaternion(pose.orientation))
        return "" if 0.99 < norm < 1.01 else f"the norm of its orientation is {norm:.3g}; allowed: 1"

    @override
    def _read(self, messages: list[Any]) -> None:
        for message in messages:
            stamp = message.header.stamp.sec + message.header.stamp.nanosec / 1e9
            now = pose_of(message.pose.pose)
            if self._last is not None:
                self._moved(now.relative_to(self._last[1]), stamp - self._last[0])
            self._last = stamp, now
            self._note_alternation(stamp, now)

    def _note_alternation(self, stamp: float, pose: Pose2) -> None:
        """Note, as a jump, that poses alternate as those of two nodes do; `stamp` in [s]."""
        self._heading += math.remainder(pose.theta - self._heading, math.tau)  # without steps at 180 deg
        found = self._alternation.note(stamp, (pose.x, pose.y, self._heading))
        if found is not None and not self.jumped:
            is_turn = found.number == 2
            size = f"{math.degrees(found.size):.2g} deg" if is_turn else f"{found.size:.2g} m"
            most = f"{MAX_ALTERNATION_DEG:g} deg" if is_turn else f"{MAX_ALTERNATION_M:g} m"
            self.jumped = (
                f"the odometry ({self.source.topic}) goes to and fro by {size} between its messages;"
                f" allowed: {most}. Do two nodes send it?"
            )

    def _moved(self, step: Pose2, seconds: float) -> None:
        """Add a step of the base to the travel of its sides; note a jump.

        Args:
            step: 2D pose of the base in the base frame at the message before.
            seconds: time between both messages, in [s].
        """
        drive = self._drive
        limits = self._limits
        most = limits.jump_factor * drive.top_speed_m_s * seconds + limits.jump_m
        most_turn = math.radians(limits.jump_factor * drive.top_turn_deg_s * seconds + limits.jump_deg)
        if math.hypot(step.x, step.y) > most or abs(step.theta) > most_turn:
            self.jumped = (
                f"the odometry ({self.source.topic}) jumps by {math.hypot(step.x, step.y):.2f} m and"
                f" {math.degrees(step.theta):.0f} deg in {seconds:.3g} s; allowed: {most:.2f} m,"
                f" {math.degrees(most_turn):.0f} deg"
            )
        half = 0.5 * step.theta
        cos, sin = math.cos(half), math.sin(half)
        chord, sideways = cos * step.x + sin * step.y, cos * step.y - sin * step.x
        stretch = half / math.sin(half) if abs(half) > 1e-9 else 1.0
        forward, turn = chord * stretch, 0.5 * step.theta * drive.tread_m
        side = sideways * stretch if drive.kind == "holonomic" else 0.0
        was = self.travel
        self.travel = WheelTravel(was.left + forward - turn, was.right + forward + turn, was.sideways + side)


class _TopicWheels:
    """Common part of both kinds of bases: the command of a period, and the odometry."""

    def __init__(self, drive: Drive, odometry: OdometryTopic, limits: RosOdometrySpec) -> None:
        """Take over the odometry of a base; `limits` are those of a jump."""
        self._drive, self._odometry = drive, odometry
        self._command = DriveCommand()
        odometry.fit(drive, limits)

    def wheel_travel(self) -> WheelTravel:
        """Return the travel of the wheels; raises `StaleSensor` without a fresh message."""
        self._odometry.check_fresh()
        return self._odometry.travel

    def taken(self) -> DriveCommand:
        """Return the command of this period, and drop it, because a command is valid for one period."""
        command, self._command = self._command, DriveCommand()
        return command


class RosBase(_TopicWheels, Base):
    """Base that is commanded over ROS by a forward speed and a turn rate."""

    @override
    def drive(self, speed: float, turn_rate: float) -> None:
        self._command = checked_command(self._drive, speed, turn_rate)


class RosHolonomicBase(_TopicWheels, HolonomicBase):
    """Base that is commanded over ROS by a forward and a sideways speed, and a turn rate."""

    @override
    def drive(self, speed: float, turn_rate: float, sideways: float = 0.0) -> None:
        self._command = checked_command(self._drive, speed, turn_rate, sideways)


def pose_of(pose: Any) -> Pose2:
    """Return the 2D pose of a `geometry_msgs/Pose` on the floor: x, y in [m] and yaw in [rad]."""
    x, y, z, w = _quaternion(pose.orientation)
    heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return Pose2(float(pose.position.x), float(pose.position.y), heading)


def _quaternion(orientation: Any) -> tuple[float, float, float, float]:
    return orientation.x, orientation.y, orientation.z, orientation.w
