"""One Kalman filter outdoors: estimation of the gyro's bias, and effect of a fix, in exact figures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_kalman import FieldKalman
from handcart.robotics.navigation.outdoors.field_model import corrected, fix_forecast, level_lever
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry

STEADY = REFERENCE_NOISE._replace(gyro_walk=0.0, gyro_warm_up=0.0, gyro_bias=0.02, gyro_white=0.005)
START = Pose2(1.0, -2.0, 0.3)
BIAS = 0.013


def rest(time: float) -> Advance:
    return Advance(0.0, 0.0, 0.0, time, time, BIAS * time)


def bias_sigma(kalman: FieldKalman) -> float:
    """Standard deviation of the estimated bias of the vertical gyro, in [rad/s]."""
    parts = [states.BIAS, states.WARM_UP]
    return math.sqrt(float(kalman.belief.covariance[np.ix_(parts, parts)].sum()))


def drive(time: float = 1.0, forward: float = 0.5) -> Advance:
    return Advance(forward, 0.0, 0.0, time, 0.0, 0.0)


def sigma_after(*times: float) -> float:
    """Return the sigma of a bias that was averaged over some rests, in [rad/s]."""
    return 1.0 / math.sqrt(1.0 / 0.02**2 + sum(times) / 0.005**2)


class Levelled(GyroOdometry):
    """Dead reckoning after its tilt was found at a stop."""

    @property
    def levelled(self) -> bool:
        return True

    @property
    def tilt(self) -> tuple[float, float]:
        return 0.04, -0.03


def test_the_bias_is_learned_once_a_second_at_rest() -> None:
    kalman = FieldKalman(START, STEADY)
    seen = []
    for _ in range(5):
        kalman.advance(rest(0.4))
        seen.append(bias_sigma(kalman))
    after = sigma_after(1.2)
    assert seen == pytest.approx([0.02, 0.02, after, after, after])
    share = 1.0 - (after / 0.02) ** 2
    assert kalman.belief.mean[states.BIAS] == pytest.approx(share * BIAS)
    kalman.advance(rest(0.2))
    assert bias_sigma(kalman) == pytest.approx(sigma_after(2.2))


def test_what_a_short_stop_told_is_taken_in_as_it_drives_off() -> None:
    kalman = FieldKalman(START, STEADY)
    kalman.advance(rest(0.3))
    assert bias_sigma(kalman) == pytest.approx(0.02)
    kalman.advance(drive())
    assert bias_sigma(kalman) == pytest.approx(sigma_after(0.3))
    kalman.advance(drive())
    assert bias_sigma(kalman) == pytest.approx(sigma_after(0.3))


def test_each_leg_slips_anew_in_its_curves() -> None:
    """The last leg's slip and its effect on the position say nothing of this leg's."""
    kalman, seen = FieldKalman(START, STEADY), []
    turning = Advance(1.0, 0.5, 0.0, 1.0, 0.0, 0.0)
    for advance in (turning, turning, rest(1.0), turning, turning):
        kalman.advance(advance)
        seen.append(bool(kalman.belief.covariance[states.X, states.TURN_SLIP] != 0.0))
        assert kalman.belief.covariance[states.TURN_SLIP, states.TURN_SLIP] == pytest.approx(0.12**2)
    assert seen == [False, True, True, False, True]


@pytest.mark.parametrize("sigma", [None, 0.4])
@pytest.mark.parametrize("odometry", [GyroOdometry(), Levelled()])
def test_a_fix_is_taken_in_with_its_own_variance(sigma: float | None, odometry: GyroOdometry) -> None:
    noise = STEADY._replace(antenna=(0.5, 0.2, 1.5), gps_delay=0.2, gps_drift=0.3, gps_white=0.7)
    kalman = FieldKalman(START, noise, 0.5)
    kalman.advance(drive(2.0, 3.0))
    mean, covariance = kalman.belief
    lever = level_lever(noise.antenna, odometry.tilt, float(mean[states.HEADING]))
    rows, expected = fix_forecast(mean, lever, 1.5)
    variance = (0.7 if sigma is None else sigma) ** 2
    variance += 0.0 if odometry.levelled else (1.5 * noise.roughness) ** 2
    position = np.add(expected, (0.3, -0.2))
    fixed = kalman.fix(position, sigma, odometry)
    after = corrected(mean, covariance, rows, position - expected, variance)
    assert fixed.believed
    assert kalman.belief.mean == pytest.approx(after[0])
    assert kalman.belief.covariance == pytest.approx(after[1])
    whole = rows @ covariance @ rows.T + variance * np.eye(2)
    square = float((position - expected) @ np.linalg.solve(whole, position - expected))
    assert fixed.square == pytest.approx(square)
    density = -0.5 * square - 0.5 * math.log((2.0 * math.pi) ** 2 * np.linalg.det(whole))
    assert fixed.log_likelihood == pytest.approx(density)


def test_a_refused_fix_says_how_far_off_and_changes_nothing() -> None:
    kalman, odometry = FieldKalman(START, STEADY._replace(antenna=(0.0, 0.0, 0.0))), GyroOdometry()
    before = kalman.belief
    fixed = kalman.fix(np.array([1.0, 8.0]), 1.0, odometry)
    assert (fixed.believed, kalman.refused, kalman.restarts) == (False, 1, 0)
    sigma = math.sqrt(1.0 + 0.05**2)
    assert fixed.square == pytest.approx((10.0 / sigma) ** 2)
    assert fixed.why == f"10.00 m off, {10.0 / sigma:.1f} sigma"
    assert (kalman.belief.mean == before.mean).all()
    assert (kalman.belief.covariance == before.covariance).all()


@pytest.mark.parametrize(("count", "odds"), [(1, 0.0), (2, math.log(0.95)), (3, math.log(0.95))])
def test_refused_fixes_that_agree_are_as_likely_as_they_last(count: int, odds: float) -> None:
    kalman, odometry = FieldKalman(START, STEADY._replace(antenna=(0.0, 0.0, 0.0))), GyroOdometry()
    for _ in range(count):
        fixed = kalman.fix(np.array([1.0, 38.0]), 1.0, odometry)
    variance = 1.0 + 0.05**2
    far = math.log(0.001) - 0.5 * 40.0**2 / (variance + 100.0) - math.log(2.0 * math.pi * (variance + 100.0))
    if count == 1:
        assert fixed.log_likelihood == pytest.approx(far)
        return
    alike = odds - math.log(2.0 * math.pi * variance * count / (count - 1.0))
    assert fixed.log_likelihood == pytest.approx(np.logaddexp(far, alike))


def test_begun_with_a_belief_it_adds_what_it_supposes_beyond() -> None:
    """More slow error of the fixes is one of the place, and cancels in their sum."""
    there, here = STEADY, STEADY._replace(gps_drift=0.8, slip=0.05, scale=0.02, turn_slip=0.2, side_slip=0.1)
    kalman = FieldKalman(START, here)
    kalman.advance(rest(0.4))
    mean = np.linspace(0.1, 1.3, states.STATE_SIZE)
    mean[states.HEADING] = 2.0 * math.pi + 0.5
    spread = np.diag(np.full(states.STATE_SIZE, 0.04))
    kalman.begin_with(Belief(mean, spread), there)
    found = kalman.belief
    assert found.mean[states.HEADING] == pytest.approx(0.5)
    assert np.delete(found.mean, states.HEADING) == pytest.approx(np.delete(mean, states.HEADING))
    expected, drift = spread.copy(), 0.8**2
    for place, error in ((states.X, states.GPS_X), (states.Y, states.GPS_Y)):
        expected[place, place] += drift
        expected[error, error] += drift
        expected[place, error] = expected[error, place] = -drift
    expected[states.SLIP, states.SLIP] += 0.05**2 - there.slip**2
    expected[states.SCALE, states.SCALE] += 0.02**2 - there.scale**2
    expected[states.TURN_SLIP, states.TURN_SLIP] += 0.2**2 - 0.12**2
    expected[states.SIDE, states.SIDE] += 0.1**2 - there.side_slip**2
    assert found.covariance == pytest.approx(expected)
    kalman.begin_with(Belief(mean, spread), here)
    assert kalman.belief.covariance == pytest.approx(spread)
    kalman.advance(rest(0.7))  # the 0.4 s before it began do not count
    assert kalman.belief.covariance[states.BIAS, states.BIAS] == pytest.approx(0.04)
