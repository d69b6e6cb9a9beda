"""Fixes that leap, as a filter supposes them; `benchmarks.field.mismatches` has whole drives."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.stats

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief, mixed
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_kalman import FieldKalman
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE, FieldNoise
from handcart.robotics.navigation.outdoors.filter_history import FixResult
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry
from handcart.robotics.navigation.outdoors.sky import leapt, log_normal
from handcart.robotics.navigation.outdoors.smoothing import TrackRecord
from handcart.robotics.numerics.arrays import FloatArray

LEAPING = REFERENCE_NOISE._replace(gps_drift=3.0, gps_drift_time=600.0, jump=3.0, jump_every=100.0)
STANDS = Advance(0.0, 0.0, 0.0, 1.0, 1.0, 0.0)


def standing(noise: FieldNoise, record: bool = False) -> FieldKalman:
    """Starts at the origin, which it knows to 5 cm."""
    return FieldKalman(Pose2(0.0, 0.0, 0.0), noise, record=TrackRecord() if record else None)


def seen(filtering: FieldKalman, fixes: FloatArray) -> list[FixResult]:
    """Return the filter's estimates for fixes (n, 2), a second apart, of a base at rest."""
    odometry, found = GyroOdometry(), []
    for fix in fixes:
        filtering.advance(STANDS)
        found.append(filtering.fix(fix, None, odometry))
    return found


def fixes(seed: int, count: int, off: tuple[float, float] = (0.0, 0.0)) -> FloatArray:
    """Return fixes (count, 2) with white noise around a place, in [m]."""
    drawn: FloatArray = np.random.default_rng(seed).standard_normal((count, 2)) + off
    return drawn


@pytest.mark.parametrize("size", [2.5, 6.0, 9.0])
def test_a_leap_is_believed_and_moves_nothing(size: float) -> None:
    """The one who supposes it goes on; the other one doubts for as long as it lasts."""
    leaping, nominal = standing(LEAPING), standing(REFERENCE_NOISE)
    for filtering in (leaping, nominal):
        seen(filtering, fixes(1, 30))
        seen(filtering, fixes(2, 30, (size, -size)))
    assert leaping.refused <= 8  # those by which a small leap shows
    assert nominal.refused >= 28
    off = leaping.belief.mean[[states.GPS_X, states.GPS_Y]]
    assert off == pytest.approx([size, -size], abs=1.2)
    assert math.hypot(*leaping.belief.mean[:2]) < 0.3


@pytest.mark.parametrize("size", [2.5, 3.0])
def test_a_rare_leap_that_only_many_fixes_show_is_believed_at_once(size: float) -> None:
    """Each of them alone may be chance; where no leap is supposed they are refused for long."""
    rare = standing(LEAPING._replace(jump_every=1e4))
    seen(rare, fixes(1, 40))
    before = rare.refused
    found = seen(rare, fixes(2, 60, (size, -size)))
    assert rare.refused - before <= 3
    assert sum(not item.believed for item in found) <= 2


def test_an_error_that_has_leapt_tells_nothing_of_the_one_before() -> None:
    root = np.random.default_rng(4).standard_normal((states.STATE_SIZE, states.STATE_SIZE))
    before = root @ root.T
    after = leapt(before, 3.0)
    error = [states.GPS_X, states.GPS_Y]
    others = [k for k in range(states.STATE_SIZE) if k not in error]
    assert np.array_equal(after[np.ix_(error, error)], 9.0 * np.eye(2))
    assert not after[np.ix_(error, others)].any()
    assert not after[np.ix_(others, error)].any()
    assert np.array_equal(after[np.ix_(others, others)], before[np.ix_(others, others)])


def test_a_leap_is_what_it_costs() -> None:
    """Less likely than none when it comes; from then on fixes are as likely as they were."""
    leaping = standing(LEAPING)
    before = [item.log_likelihood for item in seen(leaping, fixes(1, 30))]
    after = [item.log_likelihood for item in seen(leaping, fixes(2, 30, (6.0, 6.0)))]
    assert after[0] < min(before) - 2.0
    assert np.mean(after[5:]) == pytest.approx(np.mean(before), abs=0.6)


def test_an_error_that_cannot_leap_has_one_sky() -> None:
    nominal = standing(REFERENCE_NOISE)
    leaping = standing(REFERENCE_NOISE._replace(jump=3.0, jump_every=1e12))
    for one, other in zip(seen(nominal, fixes(3, 20)), seen(leaping, fixes(3, 20)), strict=True):
        assert one.log_likelihood == pytest.approx(other.log_likelihood, abs=1e-6)
    assert np.allclose(nominal.belief.mean, leaping.belief.mean, atol=1e-6)


def test_what_is_known_of_a_moment_before_a_leap_stays() -> None:
    """The smoother carries nothing of the error across it, and all of the pose."""
    leaping = standing(LEAPING, record=True)
    seen(leaping, fixes(1, 10))
    leaping.mark()
    seen(leaping, fixes(2, 10, (8.0, 0.0)))
    leaping.mark()
    first, second = leaping.smoothed()
    assert first.mean[states.GPS_X] == pytest.approx(0.0, abs=1.0)
    assert second.mean[states.GPS_X] == pytest.approx(8.0, abs=1.0)
    assert np.allclose(first.mean[:2], second.mean[:2], atol=0.02)  # it was at rest
    assert np.allclose(first.covariance[:2, :2], second.covariance[:2, :2], atol=0.02)


def test_a_mixture_spreads_as_far_as_its_parts() -> None:
    far = [Belief(np.array([-1.0, 0.0]), np.eye(2)), Belief(np.array([3.0, 0.0]), 2.0 * np.eye(2))]
    whole = mixed(far, np.array([0.75, 0.25]))
    assert whole.mean == pytest.approx([0.0, 0.0])
    assert whole.covariance == pytest.approx(np.diag([1.25 + 3.0, 1.25]))


def test_lasting_reflection_is_as_likely_as_its_first_fix() -> None:
    """Refused fixes are held against those before them, not each against nothing."""
    nominal = standing(REFERENCE_NOISE)
    seen(nominal, fixes(1, 30))
    off = [item.log_likelihood for item in seen(nominal, fixes(2, 30, (12.0, 12.0)))]
    assert off[0] < -10.0
    assert np.mean(off[5:]) > -4.5


def test_before_gravity_told_the_tilt_a_fix_is_less_exact() -> None:
    """The antenna of a base that leans isn't above it."""
    exact = REFERENCE_NOISE._replace(gps_white=0.01)
    odometry, level = GyroOdometry(), standing(exact)
    lean = math.tan(2.0 * exact.roughness) * exact.antenna[2]
    assert not odometry.levelled
    assert level.fix(np.array([lean, 0.0]), None, odometry).square < 9.0
    for _ in range(40):
        odometry.update(np.array([0.0, 0.0, 1e-4]), np.array([0.0, 0.0, 9.81]), np.zeros(2), 0.025)
    assert odometry.levelled
    assert not standing(exact).fix(np.array([0.5, 0.0]), None, odometry).believed


@pytest.mark.parametrize("covariance", [np.zeros((2, 2)), np.ones((2, 2)), np.diag([1.0, -1.0])])
def test_nothing_is_likely_by_what_is_no_covariance(covariance: FloatArray) -> None:
    with pytest.raises(ValueError, match="no covariance"):
        log_normal(np.zeros(2), covariance)


def test_a_density_is_the_normal_one() -> None:
    covariance, residual = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([0.3, -1.2])
    expected = scipy.stats.multivariate_normal(np.zeros(2), covariance).logpdf(residual)
    assert log_normal(residual, covariance) == pytest.approx(expected, rel=1e-12)
