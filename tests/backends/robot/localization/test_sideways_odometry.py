"""Odometry of a base that drives sideways, against wheels that err each by itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.localizations import odometry_errors
from handcart.backends.simulation.body.mecanum_wheels import MecanumWheels
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.holonomic_odometry import HolonomicOdometry
from handcart.robotics.navigation.odometry.odometry import OdometryErrors, SidewaysErrors

LEGS = (
    WheelTravel(0.02, 0.02),
    WheelTravel(0.0, 0.0, 0.02),
    WheelTravel(-0.005, 0.005, 0.01),
    WheelTravel(0.01, 0.01, -0.02),
)
"""Travel in a period of each leg of a drive, in [m]."""
START = Pose2(0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def spec() -> RobotFile:
    return load_robot("cart/mecanum")


def normalized_error(spec: RobotFile, seed: int, errors: OdometryErrors) -> float:
    """Return the squared error of the pose after a drive by its covariance: 3 on average if that is right."""
    wheels, truth = MecanumWheels(spec, seed), START
    odometry = HolonomicOdometry(START, spec.drive.tread_m, errors, np.zeros((3, 3)))
    for period in range(400):
        way = LEGS[period // 100]
        truth = truth.compose(wheels.motion(way, period))
        odometry.predict(*way)
    x, y, turn = np.subtract(truth, odometry.pose).tolist()
    off = np.array([x, y, wrap(turn)])
    return float(off @ np.linalg.solve(odometry.covariance, off))


@pytest.mark.slow
def test_the_covariance_of_a_sideways_drive_is_honest(spec: RobotFile) -> None:
    errors = odometry_errors(spec)
    found = [normalized_error(spec, seed, errors) for seed in range(30)]
    assert 0.05 < np.mean(found) < 3.0
    assert max(found) < 16.0


def test_without_errors_of_sideways_motion_the_claim_is_false(spec: RobotFile) -> None:
    errors = odometry_errors(spec)._replace(sideways=SidewaysErrors(1e-4, 1e-4, 1e-4))
    assert np.mean([normalized_error(spec, seed, errors) for seed in range(10)]) > 6.0


def test_a_square_driven_sideways_without_errors_closes() -> None:
    odometry = HolonomicOdometry(START, 0.7)
    for left, right, sideways in [(1, 1, 0), (0, 0, 1), (-1, -1, 0), (0, 0, -1)]:
        odometry.predict(left, right, sideways)
    assert odometry.pose.distance(START) < 1e-12
    quarter = math.pi / 2
    odometry.predict(-0.35 * quarter, 0.35 * quarter, quarter)
    assert odometry.pose == pytest.approx((-1.0, 1.0, quarter))  # of a circle of 1 m, around its left


def test_a_correction_teaches_how_far_it_drives_sideways() -> None:
    odometry = HolonomicOdometry(START, 0.7, OdometryErrors(sideways=SidewaysErrors()))
    for number in range(1, 5):
        odometry.predict(0.0, 0.0, 1.0)
        odometry.correct(Pose2(0.0, 1.04 * number, 0.0), 1e-8 * np.eye(3))
    odometry.predict(0.0, 0.0, 1.0)
    assert odometry.pose.y == pytest.approx(5 * 1.04, abs=0.004)


@pytest.mark.parametrize("number", range(6))
def test_a_constant_error_moves_the_pose_as_the_covariance_says(number: int) -> None:
    """The expected shift is computed by finite differences."""
    way, size = (0.03, 0.05, 0.04), 1e-6
    one, other = (
        HolonomicOdometry(Pose2(1.0, 2.0, 0.7), 0.7, OdometryErrors(sideways=SidewaysErrors())) for _ in "ab"
    )
    other._scales[number] = size
    one.predict(*way)
    other.predict(*way)
    change = np.subtract(other.pose, one.pose) / size
    shared = one._state[:3, 3 + number] / one._state[3 + number, 3 + number]
    assert shared == pytest.approx(change, abs=1e-3)
