from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.bent_way import rest_sigmas
from handcart.robotics.navigation.odometry.odometry import Odometry, OdometryErrors

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
    """Return the truth and the dead reckoning of one drive, with errors drawn as the covariance assumes."""
    scale = 1.0 + rng.normal(0.0, errors.radius, 2)
    tread = TREAD * (1.0 + rng.normal(0.0, errors.tread))
    truth, odometry = Odometry(Pose2(0, 0, 0.3), tread, EXACT), Odometry(Pose2(0, 0, 0.3), TREAD, errors)
    for step in steps:
        slip = errors.slip * np.sqrt(np.abs(step) * errors.slip_length)
        truth.predict(*(step * scale + rng.normal(0.0, 1.0, 2) * slip))
        odometry.predict(*step)
    return truth.pose, odometry


def squared_errors(errors: OdometryErrors, steps: np.ndarray, drives: int) -> np.ndarray:
    """(drives,) squared errors in claimed variances, of x, y and heading: 3 on average for a true claim."""
    rng, squares = np.random.default_rng(0), []
    for _ in range(drives):
        truth, odometry = worn_wheels(rng, errors, steps)
        off = difference(truth, odometry.pose)
        squares.append(off @ np.linalg.solve(odometry.covariance, off))
    return np.array(squares)


@pytest.mark.slow
def test_the_covariance_is_what_the_errors_are() -> None:
    assert 2.5 < squared_errors(OdometryErrors(0.002, 0.005, 0.01), travel(150), 200).mean() < 3.5


FILE_ERRORS, UNKNOWN_WHEELS = OdometryErrors(0.002, 0.005, 0.01), OdometryErrors()
STRAIGHT = np.full((60, 2), 0.5)
OUT_AND_BACK = np.vstack([STRAIGHT[:30], -STRAIGHT[:30]])


@pytest.mark.parametrize("steps", [STRAIGHT, OUT_AND_BACK])
@pytest.mark.parametrize("errors", [FILE_ERRORS, UNKNOWN_WHEELS])
def test_the_covariance_holds_after_a_long_drive(errors: OdometryErrors, steps: np.ndarray) -> None:
    """To first order alone the squared errors were 4 to 1300 variances."""
    assert 1.2 < squared_errors(errors, steps, 40).mean() < 4.5


@pytest.mark.parametrize("variance", [1e-4, 9.9e-3, 0.0101, 0.5, 4.0])
def test_the_rest_beyond_the_first_order_is_that_of_a_normal_error(variance: float) -> None:
    error = math.sqrt(variance) * np.sqrt(2.0) * np.polynomial.hermite.hermgauss(60)[0]
    weight = np.polynomial.hermite.hermgauss(60)[1] / math.sqrt(math.pi)
    expected = [
        math.sqrt(weight @ (1.0 - np.cos(error)) ** 2),
        math.sqrt(weight @ (error - np.sin(error)) ** 2),
    ]
    assert rest_sigmas(variance) == pytest.approx(expected, rel=0.01)


def test_a_measured_pose_takes_the_bent_way_with_it() -> None:
    """Along the path, too, the covariance is that of the measurement, and grows again from there."""
    odometry = Odometry(Pose2(0.0, 0.0, 0.0), TREAD)
    for _ in range(40):
        odometry.predict(0.5, 0.5)
    assert odometry.covariance[0, 0] > 2.0**2
    odometry.correct(Pose2(20.0, 0.0, 0.0), np.diag([0.01, 0.01, 0.001]) ** 2)
    odometry.predict(0.1, 0.1)
    assert odometry.covariance[0, 0] < 0.012**2
    assert np.linalg.eigvalsh(odometry.covariance).min() > 0.0


@pytest.mark.slow
def test_measured_poses_also_calibrate_the_wheels() -> None:
    """After a corrected drive, the next one is dead reckoned far better than by uncalibrated wheels."""
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
    """It grows from zero: by slip with the square root of the distance, by the wheels' radius in
    proportion.
    """
    odometry, sigmas = Odometry(Pose2(0.0, 0.0, 0.0), 0.5, OdometryErrors(0.01, 0.0, 0.0)), []
    for _ in range(3):
        sigmas.append(float(np.sqrt(odometry.covariance[0, 0])))
        for _ in range(30):
            odometry.predict(0.02, 0.02)
    assert sigmas == pytest.approx([0.0, 0.006 / math.sqrt(2.0), 0.012 / math.sqrt(2.0)], rel=0.02, abs=1e-5)


def arc(left: float, right: float, tread: float, start: Pose2) -> np.ndarray:
    """Return the end of an arc, by its radius."""
    turn = (right - left) / tread
    radius = 0.5 * (left + right) / turn
    end = start.compose(Pose2(radius * math.sin(turn), radius * (1.0 - math.cos(turn)), turn))
    return np.array(end)


ONCE = [
    (OdometryErrors(0.03, 0.0, 0.0), [0, 1]),
    (OdometryErrors(0.0, 0.04, 0.0), [2]),
    (OdometryErrors(0.0, 0.0, 0.05, 0.2), [3, 4]),
    (OdometryErrors(0.03, 0.04, 0.05, 0.2), [0, 1, 2, 3, 4]),
]


@pytest.mark.parametrize(("left", "right"), [(0.02, 0.025), (-0.025, 0.02), (-0.02, -0.03)])
@pytest.mark.parametrize(("errors", "which"), ONCE)
def test_each_error_adds_what_its_derivative_says(
    errors: OdometryErrors, which: list[int], left: float, right: float
) -> None:
    """Against differences of an arc: radius of each wheel, tread, slip of each wheel."""
    start = Pose2(1.0, 2.0, 0.7)
    prior = np.array([[0.04, 0.01, 0.0], [0.01, 0.05, 0.002], [0.0, 0.002, 0.03]])
    sigmas = [errors.radius, errors.radius, errors.tread]
    sigmas += [errors.slip * math.sqrt(errors.slip_length / abs(way)) for way in (left, right)]
    expected, columns = np.zeros((3, 3)), []
    for k in range(3):
        aside = np.eye(3)[k] * 1e-6
        ends = [arc(left, right, TREAD, Pose2(*(np.array(start) + sign * aside))) for sign in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / 2e-6)
    by_pose = np.array(columns).T
    expected += by_pose @ prior @ by_pose.T
    for k in which:
        ends = []
        for sign in (1.0, -1.0):
            change = 1.0 + sign * 1e-6 * np.array([k in (0, 3), k in (1, 4), k == 2])
            ends.append(arc(left * change[0], right * change[1], TREAD * change[2], start))
        column = (ends[0] - ends[1]) / 2e-6
        expected += sigmas[k] ** 2 * np.outer(column, column)
    odometry = Odometry(start, TREAD, errors, prior)
    odometry.predict(left, right)
    assert odometry.pose == pytest.approx(tuple(arc(left, right, TREAD, start)))
    added, wanted = odometry.covariance - prior, expected - prior
    assert added == pytest.approx(wanted, rel=0.02, abs=0.003 * np.abs(wanted).max())


def test_what_is_known_of_the_wheels_is_told() -> None:
    odometry = Odometry(Pose2(0, 0, 0), TREAD, OdometryErrors(0.03, 0.04, 0.0))
    assert odometry.scale_variance == pytest.approx(2.0 * 0.03**2 / 4.0)
    turn = 0.03**2 * (0.2**2 + 0.3**2) + 0.04**2 * 0.1**2
    assert odometry.turn_variance(0.2, 0.3) == pytest.approx(turn / TREAD**2)
    odometry.doubt_scale(0.1)
    assert odometry.scale_variance == pytest.approx(2.0 * 0.03**2 / 4.0 + 0.1**2)
    assert odometry.turn_variance(0.2, 0.2) == pytest.approx(2.0 * 0.03**2 * 0.2**2 / TREAD**2)


def test_a_wider_slip_factor_widens_slip_alone() -> None:
    spreads = []
    for factor in (1.0, 4.0):
        odometry = Odometry(Pose2(0, 0, 0), TREAD, OdometryErrors(0.0, 0.0, 0.05, 0.2))
        odometry.slip_factor = factor
        odometry.predict(0.1, 0.1)
        spreads.append(odometry.covariance)
    assert spreads[1] == pytest.approx(4.0 * spreads[0], abs=1e-8)


def test_a_measured_pose_corrects_the_wheels_as_a_kalman_filter() -> None:
    """Its gain, by hand: one straight way, and a position along it that is known exactly."""
    odometry = Odometry(
        Pose2(0, 0, 0), TREAD, OdometryErrors(0.03, 0.0, 0.0), np.diag([0.01, 0.01, 0.01]) ** 2
    )
    odometry.predict(1.0, 1.0)
    prior = odometry.covariance[0, 0]
    assert prior == pytest.approx(0.01**2 + 0.03**2 / 2.0, rel=0.01)  # beyond the first order a little more
    odometry.correct(
        Pose2(1.02, 0.0, 0.0), np.diag([1e-12, odometry.covariance[1, 1], odometry.covariance[2, 2]])
    )
    learned = 0.5 * 0.03**2 * 0.02 / prior
    odometry.predict(1.0, 1.0)
    assert odometry.pose.x == pytest.approx(1.02 + 1.0 + learned, rel=1e-3)
    left = 0.03**2 / 2.0 - (0.5 * 0.03**2) ** 2 / prior
    assert odometry.scale_variance == pytest.approx(left, rel=1e-3)
