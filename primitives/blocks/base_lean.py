"""Tilt of the base that its accelerometers measure beyond the suspension's model."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from handcart.backends.capabilities.imu import Imu
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.manipulation.suspension.suspension_model import base_motion
from handcart.robotics.numerics.arrays import FloatArray

TILT_AVERAGING_S = 1.0  # at rest
GRAVITY_M_S2 = 9.81


def felt_beside(robot: Robot) -> Generator[None, None, FloatArray]:
    """Measure the roll and pitch (2,) of the base that its suspension's model does not predict, in [rad].

    It is the measured tilt minus the model's tilt for the current pose of the hand. The measured tilt is from
    accelerations of an IMU, averaged while the robot is at rest. The result includes the mounting error of
    the sensors and the slope of the floor.
    """
    felt = []
    for _ in range(_count(robot)):
        yield
        felt.append(robot.get(Imu).accelerations())  # type: ignore[type-abstract]
    x, y, z = np.mean(felt, axis=0).tolist()
    known, (ahead, left) = robot.spec.suspension.model, robot.base_T("hand")[:2, 3].tolist()
    modelled = (known.roll_per_m * left, known.pitch_per_m * ahead)
    return np.asarray(np.array([math.atan2(y, z), math.atan2(-x, math.hypot(y, z))]) - modelled)


def unmodelled_leans(robot: Robot, then: FloatArray, now: FloatArray) -> tuple[Transform, Transform]:
    """Return the part of the base's tilt, at each of two times, that the suspension's model does not predict.

    The model is linear in the hand's position, but the effect of a real arm's weight is not. Mounting error
    of the sensors and slope of the floor are equal at both times, so that only the difference counts. Each
    tilt gets half of the difference, the earlier one with the opposite sign, because these are the smallest
    tilts that explain the difference. Then they are reduced by their share of noise (James and Stein 1961,
    positive part, per axis), nearly to 0 if the model is right. Both tilts are returned as poses (4, 4) of
    the tilted base in the frame of the base without this tilt.

    Args:
        robot: robot whose suspension model is used.
        then: (2,) roll and pitch in [rad] by the IMU, less the model's, at the earlier time (result of
            `felt_beside`).
        now: (2,) the same difference at the present time.
    """
    half, pivot = (now - then) / 2.0, robot.spec.suspension.model.pivot
    half = half * np.maximum(0.0, 1.0 - _variance(robot) / 2.0 / np.maximum(half**2, 1e-18))
    roll, pitch = half.tolist()
    return base_motion(0.0, -roll, -pitch, pivot), base_motion(0.0, roll, pitch, pivot)


def _count(robot: Robot) -> int:
    return math.ceil(TILT_AVERAGING_S / robot.period)


def _variance(robot: Robot) -> float:
    """Return the variance of an averaged tilt, in [rad²]."""
    assert robot.spec.imu is not None
    return (robot.spec.imu.accelerometer_sigma_m_s2 / GRAVITY_M_S2) ** 2 / _count(robot)
