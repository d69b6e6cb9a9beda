"""Small motions of the base, measured by its odometry and by a person."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.backends.capabilities.base import Base, HolonomicBase, WheelTravel
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.evaluation.bringup.operator import Held
from handcart.evaluation.bringup.rung import RungFailed
from handcart.robotics.geometry.pose2 import Pose2

from .ros_site import RosSite

SPEED_M_S = 0.15
TURN_DEG_S = 20.0
SETTLE_S = 1.0


class Motion(NamedTuple):
    """Motion of the base in its own frame, as distances or as speeds."""

    forward: float
    """Motion forward, in [m]."""
    sideways: float
    """Motion sideways, in [m], positive to the left."""
    turn: float
    """Turn, in [rad], positive to the left."""


def base_of(backend: RosBackend) -> Base:
    """Return the base of a robot that is driven by ROS topics; every such robot has one."""
    base = backend.get(Base)  # type: ignore[type-abstract]
    assert base is not None, "every robot has a drive"
    return base


def command(base: Base, forward: float, turn: float, sideways: float) -> None:
    """Command the speeds of the base for one period.

    Args:
        base: the base.
        forward: speed forward, in [m/s].
        turn: turn rate, in [rad/s], positive to the left.
        sideways: speed to the left, in [m/s]; ignored by a base that cannot move sideways.
    """
    if isinstance(base, HolonomicBase):
        base.drive(forward, turn, sideways)
    else:
        base.drive(forward, turn)


def moved(site: RosSite, before: WheelTravel, now: WheelTravel) -> Motion:
    """Return the base's motion between two wheel readings; the turn follows from the tread in the robot's
    file.
    """
    left, right = now.left - before.left, now.right - before.right
    turn = (right - left) / site.robot.drive.tread_m
    return Motion(0.5 * (left + right), now.sideways - before.sideways, turn)


def true_pose(backend: RosBackend) -> Pose2:
    """Return the true pose world_T_base on a simulated bench; the zero pose for a real robot."""
    truth = backend.ground_truth()
    return Pose2(0.0, 0.0, 0.0) if truth is None else truth.base


def true_motion(before: Pose2, now: Pose2) -> Motion:
    """Return the motion from a pose to a later one, in the frame of the earlier pose."""
    step = now.relative_to(before)
    return Motion(step.x, step.y, step.theta)


class DriveTrial(NamedTuple):
    """Commanded, measured and true motion of the base in a drive at constant speeds."""

    commanded: Motion
    """Speeds times their duration."""
    measured: Motion
    """Motion by the odometry."""
    true: Motion
    """Motion by the ground truth of a bench; zero for a real robot."""
    latency_s: float
    """Time from the first command until the odometry moved; NaN if it never did."""


def drive(site: RosSite, backend: RosBackend, held: Held, speeds: Motion, seconds: float) -> DriveTrial:
    """Drive with constant speeds while a key is held, stop, and wait until the base is at rest.

    Args:
        site: robot or bench.
        backend: the robot.
        held: returns whether the key is still held.
        speeds: in [m/s] and [rad/s].
        seconds: duration in [s].

    Raises:
        RungFailed: the key was let go.
    """
    base, period = base_of(backend), backend.period
    before, pose = base.wheel_travel(), true_pose(backend)
    count, latency = round(seconds / period), math.nan
    for number in range(count):
        if not held():
            backend.stop()
            raise RungFailed("the key was let go before the motion was over")
        command(base, speeds.forward, speeds.turn, speeds.sideways)
        backend.step()
        if math.isnan(latency) and np.abs(moved(site, before, base.wheel_travel())).max() > 1e-3:
            latency = (number + 1) * period
    backend.stop()
    for _ in range(round(SETTLE_S / period)):
        backend.step()
    asked = Motion(*(speed * count * period for speed in speeds))
    measured = moved(site, before, base.wheel_travel())
    return DriveTrial(asked, measured, true_motion(pose, true_pose(backend)), latency)
