"""How the base leans, as its accelerometers feel it, beside what its suspension's model says."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from handcart.backends.capabilities.imu import Imu
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.manipulation.suspension.suspension_model import base_motion

AVERAGED = 1.0  # [s] at rest
GRAVITY = 9.81  # [m/s²]

Vector = NDArray[np.float64]


def felt_beside(robot: Robot) -> Generator[None, None, Vector]:
    """Roll and pitch (2,) in [rad] beside what the suspension's model says, with the hand where it is.

    Averaged while the robot stands; it has inertial sensors, and is at rest. Whatever the sensors are mounted
    askew by, and the floor isn't level by, is in it.
    """
    felt = []
    for _ in range(_count(robot)):
        yield
        felt.append(robot.get(Imu).accelerations())  # type: ignore[type-abstract]
    x, y, z = np.mean(felt, axis=0).tolist()
    known, (ahead, left) = robot.spec.suspension.model, robot.base_T("hand")[:2, 3].tolist()
    modelled = (known.roll_per_m * left, known.pitch_per_m * ahead)
    return np.asarray(np.array([math.atan2(y, z), math.atan2(-x, math.hypot(y, z))]) - modelled)


def unmodelled_leans(robot: Robot, then: Vector, now: Vector) -> tuple[Transform, Transform]:
    """By how much the base leant otherwise than its model says, and leans now, as motions (4, 4).

    The model is linear in where the hand is; the weight of a real arm isn't. What sensors and floor are askew
    by is the same then and now, so only the difference counts, half of it each time: the least that explains
    what was felt. It is shrunk by how much of it is noise (James and Stein 1961, positive part, by axis):
    where the model is right, hardly any is left.

    Args:
        robot: its suspension's model is meant.
        then: what `felt_beside` gave.
        now: and gives now.
    """
    half, pivot = (now - then) / 2.0, robot.spec.suspension.model.pivot
    half = half * np.maximum(0.0, 1.0 - _variance(robot) / 2.0 / np.maximum(half**2, 1e-18))
    roll, pitch = half.tolist()
    return base_motion(0.0, -roll, -pitch, pivot), base_motion(0.0, roll, pitch, pivot)


def _count(robot: Robot) -> int:
    return math.ceil(AVERAGED / robot.period)


def _variance(robot: Robot) -> float:
    """Of a mean tilt, in [rad²]."""
    assert robot.spec.imu is not None
    return (robot.spec.imu.accelerometer_sigma_m_s2 / GRAVITY) ** 2 / _count(robot)
