"""Limits of the search for a heading: when it is known, when the search restarts, which headings stay
possible.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_model import TILT_SIGMA_RAD
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE, RTK_NOISE
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry
from handcart.robotics.navigation.outdoors.heading_bank import HEADING_COUNT, HeadingBank

START = Pose2(3.0, 4.0, 0.5)
APART = 2.0 * math.pi / HEADING_COUNT


def test_at_first_all_headings_are_as_likely() -> None:
    bank = HeadingBank(START, REFERENCE_NOISE, 0.2)
    mean, covariance = bank.belief
    assert mean[:3] == pytest.approx([3.0, 4.0, 0.5 - 0.5 * APART])
    even = APART**2 * (HEADING_COUNT**2 - 1.0) / 12.0
    assert covariance[2, 2] == pytest.approx(even + (0.6 * APART) ** 2)
    assert covariance[:2, :2] == pytest.approx(0.04 * np.eye(2))


@pytest.mark.parametrize(("drift", "supposed"), [(0.0, 1.5), (1.4, 1.5), (1.6, 1.6)])
def test_some_slow_error_of_the_fixes_is_supposed(drift: float, supposed: float) -> None:
    noise = REFERENCE_NOISE._replace(gps_white=2.0, gps_drift=drift, gps_drift_time=300.0)
    bank = HeadingBank(START, noise, 0.2)
    assert bank.belief.covariance[states.GPS_X, states.GPS_X] == pytest.approx(
        supposed**2 + TILT_SIGMA_RAD**2
    )
    bank.advance(Advance(0.0, 0.0, 0.0, 30.0, 30.0, 0.0))
    assert bank.belief.covariance[states.GPS_Y, states.GPS_Y] == pytest.approx(
        supposed**2 + TILT_SIGMA_RAD**2
    )
    bank.fix(np.array([4.0, 4.0]), 2.0, GyroOdometry())
    error = bank.belief.mean[states.GPS_X]
    assert error > 0.0
    bank.advance(Advance(0.0, 0.0, 0.0, 30.0, 30.0, 0.0))
    time = 60.0 if drift < 1.5 else 300.0
    assert bank.belief.mean[states.GPS_X] == pytest.approx(error * math.exp(-30.0 / time))


def test_a_heading_is_known_from_the_sixth_fix_on() -> None:
    bank, known = HeadingBank(START, REFERENCE_NOISE, 0.2), []
    for _ in range(7):
        bank.fix(np.array([3.0, 4.0]), 1.0, GyroOdometry())
        known.append(bank.is_known(10.0))
    assert known == [False] * 5 + [True] * 2
    assert not bank.is_known(1.0)


def test_fixes_that_fit_no_heading_make_it_begin_anew() -> None:
    """Each of them counts a tenth: four in a row are more than 30 %, nine more than 60 %."""
    bank, known = HeadingBank(START, REFERENCE_NOISE, 0.2), []
    for _ in range(6):
        bank.fix(np.array([3.0, 4.0]), 1.0, GyroOdometry())
    far = np.array([103.0, 4.0])
    for _ in range(8):
        bank.fix(far, 1.0, GyroOdometry())
        known.append(bank.is_known(10.0))
        assert bank.pose.x < 30.0
    assert known == [True] * 3 + [False] * 5
    bank.fix(far, 1.0, GyroOdometry())
    assert (bank.pose.x, bank.pose.y) == pytest.approx((103.0, 4.0), abs=1e-6)
    assert bank.belief.covariance[0, 0] == pytest.approx(9.0)
    assert not bank.is_known(10.0)


def test_other_headings_never_become_impossible() -> None:
    """A thousandth of all: fixes may be off together."""
    bank, odometry = HeadingBank(Pose2(0.0, 0.0, 0.0), RTK_NOISE, 0.02), GyroOdometry()
    for second in range(1, 11):
        bank.advance(Advance(1.0, 0.0, 0.0, 1.0, 0.0, 0.0))
        bank.fix(np.array([float(second), 0.0]), 0.01, odometry)
    open_still = 1e-3 * APART**2 * (HEADING_COUNT**2 - 1.0) / 12.0
    assert bank.belief.covariance[2, 2] == pytest.approx(open_still, rel=0.2)


def test_at_rest_each_heading_learns_the_gyros_bias() -> None:
    noise = REFERENCE_NOISE._replace(gyro_walk=0.0, gyro_warm_up=0.0, gyro_bias=0.02, gyro_white=0.005)
    bank = HeadingBank(START, noise, 0.2)
    bank.advance(Advance(0.0, 0.0, 0.0, 2.0, 0.5, 0.5 * 0.013))
    variance = 1.0 / (1.0 / 0.02**2 + 0.5 / 0.005**2)
    assert bank.belief.covariance[states.BIAS, states.BIAS] == pytest.approx(variance)
    assert bank.belief.mean[states.BIAS] == pytest.approx(0.013 * (1.0 - variance / 0.02**2))
