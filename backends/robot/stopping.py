"""How long and how far a robot goes on after it was told to stop."""

from __future__ import annotations

from .robot import Robot

LATEST = 3
"""Control periods within which the stop command leaves."""


def stopping_distance(robot: Robot) -> float:
    """The farthest that the base rolls on after the word, in [m]: three periods at top speed, its ramp."""
    speed = robot.drive_limits.speed
    return speed * LATEST * robot.period + speed**2 / (2.0 * robot.drive_limits.acceleration)


def stopping_ramp(robot: Robot) -> float:
    """The longest that anything moves on after the stop command has left, in [s]: from top speed."""
    drive = robot.spec.drive
    base = drive.top_speed_m_s / drive.acceleration_m_s2
    turn = drive.top_turn_deg_s / drive.turn_acceleration_deg_s2
    ramps = robot.spec.joint_speeds() / robot.spec.joint_accelerations()
    return max([base, turn, *map(float, ramps)])
