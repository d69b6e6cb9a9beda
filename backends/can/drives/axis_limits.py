"""Limits of the commands to an axis."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.backends.description.can_spec import GripperDriveSpec, JointDriveSpec, WheelDriveSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.kinematics.arm_model import ArmModel

_QUICKER = 2.0  # than usual slowing down: a quick stop
_STIFFER = 10.0  # than the arm's own ramps: a drive that plans ways to points must not lag behind
_OPENS = 20.0  # a second: the fingers are at speed within 50 ms
FULL_TORQUE = 1000
"""Value of the torque object (6077h) at rated torque."""


class AxisLimits(NamedTuple):
    """Limits of an axis' position, speed, acceleration and torque.

    Positions are in [m] for a wheel's rim, a sliding joint or the fingers' opening, in [rad] for a turning
    joint.
    """

    speed: float
    """Highest commanded speed, in [m/s] or [rad/s]."""
    acceleration: float
    """Acceleration of the drive's ramps, in [m/s²] or [rad/s²]."""
    braking: float
    """Deceleration of a quick stop, in [m/s²] or [rad/s²]."""
    lower: float
    """Lowest position, in [m] or [rad]; minus infinity: the axis turns without end."""
    upper: float
    window: float
    """Largest following error, in [m] or [rad]; infinity: the axis may be blocked."""
    torque: int
    """Maximum torque, in thousandths of the rated torque."""


def rim_speed(robot: RobotFile) -> float:
    """Return the speed of the outer wheel's rim, in [m/s], when the base drives at top speed and top turn
    rate.
    """
    drive = robot.drive
    return drive.top_speed_m_s + math.radians(drive.top_turn_deg_s) * drive.tread_m / 2


def rim_acceleration(robot: RobotFile) -> float:
    """Return the acceleration of the outer wheel's rim, in [m/s²], at the base's largest acceleration ahead
    and in turn.
    """
    drive = robot.drive
    return drive.acceleration_m_s2 + math.radians(drive.turn_acceleration_deg_s2) * drive.tread_m / 2


def wheel_limits(robot: RobotFile, spec: WheelDriveSpec) -> AxisLimits:
    """Return the limits of a wheel drive's travel, speed and acceleration, in [m], [m/s] and [m/s²] of the
    rim.
    """
    speed, rate = rim_speed(robot), rim_acceleration(robot)
    window = spec.following_mm / 1e3
    return AxisLimits(speed, rate, _QUICKER * rate, -math.inf, math.inf, window, FULL_TORQUE)


def joint_limits(robot: RobotFile, spec: JointDriveSpec, model: ArmModel, joint: int) -> AxisLimits:
    """Return the limits of position, speed, acceleration and torque of one joint of the arm.

    Positions, also in speeds and accelerations, are in [rad], or in [m] for a sliding joint.

    Args:
        robot: robot file.
        spec: drive of the joint, from the section `can`.
        model: model of the arm.
        joint: index of the joint in the arm, from 0.
    """
    assert robot.arm is not None
    speed = min(float(model.velocity[joint]), float(robot.joint_speeds()[joint]))
    rate = float(robot.joint_accelerations()[joint])
    endless = bool(model.endless[joint])
    lower, upper = (
        (-math.inf, math.inf) if endless else (float(model.lower[joint]), float(model.upper[joint]))
    )
    window = spec.following
    return AxisLimits(speed, _STIFFER * rate, _QUICKER * rate, lower, upper, window, FULL_TORQUE)


def gripper_limits(robot: RobotFile, spec: GripperDriveSpec) -> AxisLimits:
    """Return the limits of the fingers' opening in [m], its speed in [m/s] and its acceleration in [m/s²]."""
    assert robot.gripper is not None
    speed, opening = robot.gripper.speed_mm_s / 1e3, robot.gripper.opening_mm / 1e3
    torque = round(10.0 * spec.top_torque_percent)
    return AxisLimits(speed, _OPENS * speed, _OPENS * speed, 0.0, opening, math.inf, torque)
