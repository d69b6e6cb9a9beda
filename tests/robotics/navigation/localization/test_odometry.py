from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.odometry import Odometry, OdometryErrors

TREAD = 0.5
EXACT = OdometryErrors(0.0, 0.0, 0.0)


def difference(a: Pose2, b: Pose2) -> np.ndarray:
    return np.array([a.x - b.x, a.y - b.y, wrap(a.theta - b.theta)])


def travel(steps: int) -> np.ndarray:
    """(n, 2) wheel travel of a drive with bends, in [m]."""
    turn = 0.02 * np.sin(np.linspace(0.0, 9.0, steps))
    return np.column_stack([0.02 - turn * TREAD / 2, 0.02 + turn * TREAD / 2])


@given(st.floats(0.05, 3.0), st.floats(-math.pi, math.pi), st.integers(1, 40))
def test_a_circle_is_integrated_exactly(radius: float, theta: float, pieces: int) -> None:
    odometry = Odometry(Pose2(1.0, 2.0, theta), TREAD, EXACT)
    for _ in range(pieces):
        turn = 1.5 / pieces
        odometry.predict(turn * (radius - TREAD / 2), turn * (radius + TREAD / 2))
    local = Pose2(radius * math.sin(1.5), radius * (1 - math.cos(1.5)), 1.5)
    assert np.allclose(difference(odometry.pose, Pose2(1.0, 2.0, theta).compose(local)), 0.0, atol=1e-9)
    assert np.allclose(odometry.covariance, 0.0, atol=1e-15)


def test_turning_in_place_stays_in_place() -> None:
    odometry = Odometry(Pose2(0, 0, 0), TREAD)
    odometry.predict(-0.1, 0.1)
    assert odometry.pose == pytest.approx((0.0, 0.0, 0.4))


def test_a_base_turns_about_a_wheel_that_stands() -> None:
    odometry = Odometry(Pose2(0, 0, 0), TREAD, EXACT)
    odometry.predict(0.0, 0.0)
    assert odometry.pose == Pose2(0, 0, 0)
    odometry.predict(0.0, 0.1)
    assert odometry.pose.theta == pytest.approx(0.2)
    odometry.predict(0.1, 0.0)
    assert odometry.pose.theta == pytest.approx(0.0)
    assert odometry.pose.x == pytest.approx(0.1, abs=0.01)


def worn_wheels(
    rng: np.random.Generator, errors: OdometryErrors, steps: np.ndarray
) -> tuple[Pose2, Odometry]:
    """Truth and dead reckoning of one drive with errors drawn as the covariance assumes."""
    scale = 1.0 + rng.normal(0.0, errors.radius, 2)
    tread = TREAD * (1.0 + rng.normal(0.0, errors.tread))
    truth, odometry = Odometry(Pose2(0, 0, 0.3), tread, EXACT), Odometry(Pose2(0, 0, 0.3), TREAD, errors)
    for step in steps:
        slip = errors.slip * np.sqrt(np.abs(step) * errors.slip_length)
        truth.predict(*(step * scale + rng.normal(0.0, 1.0, 2) * slip))
        odometry.predict(*step)
    return truth.pose, odometry


@pytest.mark.slow
def test_the_covariance_is_what_the_errors_are() -> None:
    rng = np.random.default_rng(0)
    squares = []
    for _ in range(200):
        truth, odometry = worn_wheels(rng, OdometryErrors(0.002, 0.005, 0.01), travel(150))
        off = difference(truth, odometry.pose)
        squares.append(off @ np.linalg.solve(odometry.covariance, off))
    assert 2.5 < np.mean(squares) < 3.5


def test_measured_poses_also_calibrate_the_wheels() -> None:
    """After a corrected drive, the next one is dead reckoned far better than by wheels that nobody knows."""
    rng = np.random.default_rng(1)
    errors = OdometryErrors(0.005, 0.01, 0.0005)
    off = []
    for _ in range(40):
        scale = 1.0 + rng.normal(0.0, errors.radius, 2)
        tread = TREAD * (1.0 + rng.normal(0.0, errors.tread))
        truth, odometry = Odometry(Pose2(0, 0, 0), tread, EXACT), Odometry(Pose2(0, 0, 0), TREAD, errors)
        for i, step in enumerate(np.tile(travel(200), (2, 1))):
            truth.predict(*(step * scale))
            odometry.predict(*step)
            if i < 200 and i % 20 == 19:
                odometry.correct(truth.pose, np.eye(3) * 1e-8)
        off.append(difference(truth.pose, odometry.pose)[2])
    unknown = math.sqrt(worn_wheels(rng, errors, travel(200))[1].covariance[2, 2])
    assert np.std(off) < 0.3 * unknown


def test_reset_forgets_the_pose() -> None:
    odometry = Odometry(Pose2(0, 0, 0), TREAD)
    odometry.predict(1.0, 1.1)
    odometry.reset(Pose2(3, 4, 0.5), np.diag([0.1, 0.2, 0.3]))
    assert odometry.pose == Pose2(3, 4, 0.5)
    assert np.allclose(odometry.covariance, np.diag([0.1, 0.2, 0.3]))


def test_the_covariance_grows_with_the_way() -> None:
    """From nothing: by the slip with its square root, by the wheels' radius in proportion."""
    odometry, sigmas = Odometry(Pose2(0.0, 0.0, 0.0), 0.5, OdometryErrors(0.01, 0.0, 0.0)), []
    for _ in range(3):
        sigmas.append(float(np.sqrt(odometry.covariance[0, 0])))
        for _ in range(100):
            odometry.predict(0.02, 0.02)
    assert sigmas == pytest.approx([0.0, 0.02 / math.sqrt(2.0), 0.04 / math.sqrt(2.0)], rel=0.02, abs=1e-5)
