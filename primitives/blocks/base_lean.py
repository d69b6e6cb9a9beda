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


def felt_tilt(robot: Robot) -> Generator[None, None, tuple[float, float]]:
    """Roll and pitch in [rad], averaged while the robot stands; it has inertial sensors, and is at rest."""
    felt = []
    for _ in range(_count(robot)):
        yield
        felt.append(robot.get(Imu).accelerations())  # type: ignore[type-abstract]
    x, y, z = np.mean(felt, axis=0).tolist()
    return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


def unmodelled_lean(robot: Robot, tilt: tuple[float, float], reach: tuple[float, float]) -> Transform:
    """By how much the base leans otherwise than the suspension's model says, as a motion (4, 4).

    The model is linear in where the hand is; the weight of a real arm isn't. What is felt beside the model is
    shrunk by how much of it is noise (James and Stein 1961, positive part, by axis): where the model is
    right, hardly any is left.

    Args:
        robot: its sensors are aligned with its base, which stands on a level floor.
        tilt: roll and pitch in [rad], as `felt_tilt` gives them.
        reach: where the hand was then, in the base frame, in [m].
    """
    known, (x, y) = robot.spec.suspension.model, reach
    off = np.array(tilt) - (known.roll_per_m * y, known.pitch_per_m * x)
    roll, pitch = (off * np.maximum(0.0, 1.0 - _variance(robot) / np.maximum(off**2, 1e-18))).tolist()
    return base_motion(0.0, roll, pitch, known.pivot)


def _count(robot: Robot) -> int:
    return math.ceil(AVERAGED / robot.period)


def _variance(robot: Robot) -> float:
    """Of a mean tilt, in [rad²]."""
    assert robot.spec.imu is not None
    return (robot.spec.imu.accelerometer_sigma_m_s2 / GRAVITY) ** 2 / _count(robot)
