"""Leaving what the base ran into, before anything else."""

from __future__ import annotations

from collections.abc import Generator

from handcart.backends.robot.robot import Robot

BACK_OFF_M = 0.03  # more than the pose errs by: a base that turns while it touches something rubs along it
BACK_OFF_SPEED_M_S = 0.1
BACK_OFF_TIMEOUT_S = 2.0


def back_off(robot: Robot, forwards: bool) -> Generator[None, None, None]:
    """Drive straight back by `BACK_OFF_M`, away from where the base was driven, `forwards` or not."""
    begun, end = robot.localization.odometry_pose, robot.time + BACK_OFF_TIMEOUT_S
    limits, speed = robot.drive_limits, 0.0
    while robot.localization.odometry_pose.distance(begun) < BACK_OFF_M and robot.time < end:
        speed = min(speed + limits.acceleration * robot.period, BACK_OFF_SPEED_M_S, limits.speed)
        robot.base.drive(-speed if forwards else speed, 0.0)
        yield
