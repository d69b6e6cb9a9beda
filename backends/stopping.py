"""How far a robot goes on after it was told to stop."""

from __future__ import annotations

from .robot import Robot

LATEST = 3
"""Control periods within which the stop command leaves."""


def stopping_distance(robot: Robot) -> float:
    """The farthest that the base rolls on after the word, in [m]: three periods at top speed, its ramp."""
    speed = robot.drive_limits.speed
    return speed * LATEST * robot.period + speed**2 / (2.0 * robot.drive_limits.acceleration)
