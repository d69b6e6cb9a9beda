"""A start with unknown heading; `benchmarks.field.headings` has more runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from benchmarks.field.field_course import straight_course
from benchmarks.field.field_drive import PERIOD_S, FieldTimes
from benchmarks.field.field_log import record_course
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.field_model import GPS_X, X
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE, RTK_NOISE, FieldNoise
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance, GyroOdometry
from handcart.robotics.navigation.outdoors.heading_bank import KNOWN_HEADING_SIGMA_RAD, HeadingBank
from handcart.robotics.navigation.outdoors.particle_filter import ParticleErrors, ParticleFilter
from handcart.robotics.numerics.arrays import FloatArray

Away = Callable[[int], FloatArray]


def no_error(second: int) -> FloatArray:
    return np.zeros(2)


def driven_until_known(localizer: FieldLocalizer, noise: FieldNoise, seed: int) -> tuple[float, float]:
    """Seconds of driving after which the heading is known, and how far it is off then, in [rad]."""
    log = record_course(straight_course(3), noise, seed, FieldTimes(wait=10.0, dwell=5.0))
    fixes, drove = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True)), 0.0
    for row in range(len(log.rates)):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if row in fixes:
            localizer.fix(fixes[row])
        drove += PERIOD_S * bool(log.drive.driven[row, 0] > 0.0)
        if localizer.heading_known:
            return drove, abs(wrap(localizer.pose.theta - float(log.drive.poses[row, 2])))
    return math.inf, math.inf


def log_pose(noise: FieldNoise, seed: int, seconds: float) -> list[float]:
    """Return the pose of the base after some seconds of driving."""
    drive = record_course(straight_course(3), noise, seed, FieldTimes(wait=10.0, dwell=5.0)).drive
    row = int(np.searchsorted(np.cumsum(drive.driven[:, 0] > 0.0) * PERIOD_S, seconds - 1e-9))
    pose: list[float] = drive.poses[row].tolist()
    return pose


@pytest.mark.parametrize("noise", [REFERENCE_NOISE, RTK_NOISE], ids=["white 1 m", "RTK"])
@pytest.mark.parametrize("heading", [0.0, 2.5, -1.2])
def test_the_heading_is_found_on_the_way(noise: FieldNoise, heading: float) -> None:
    localizer = GpsFilter(Pose2(0.0, 0.0, heading), noise._replace(start_heading=math.inf))
    assert localizer.covariance[2, 2] > 1.0
    seconds, off = driven_until_known(localizer, noise, 3)
    assert seconds < 40.0
    assert localizer.pose.distance(Pose2(*log_pose(noise, 3, seconds))) < 1.5
    assert off < 3.0 * math.sqrt(localizer.covariance[2, 2])
    assert math.sqrt(localizer.covariance[2, 2]) < math.radians(5.0)


def test_outliers_do_not_turn_it() -> None:
    noise = REFERENCE_NOISE._replace(outliers=0.1, outlier=30.0)
    localizer = GpsFilter(Pose2(0.0, 0.0, 1.0), REFERENCE_NOISE._replace(start_heading=math.inf))
    seconds, off = driven_until_known(localizer, noise, 4)
    assert seconds < 60.0
    assert off < math.radians(12.0)


def test_standing_still_tells_no_heading() -> None:
    localizer = GpsFilter(Pose2(5.0, 7.0, 0.0), REFERENCE_NOISE._replace(start_heading=math.inf))
    rng = np.random.default_rng(0)
    for _ in range(120):
        localizer.predict(np.zeros(3), np.array([0.0, 0.0, 9.81]), np.zeros(2), 1.0)
        localizer.fix(np.array([5.0, 7.0]) + rng.standard_normal(2))
    assert not localizer.heading_known
    assert localizer.covariance[2, 2] == pytest.approx(math.pi**2 / 3.0)
    assert localizer.meanwhile is not None
    assert localizer.meanwhile.covariance[2, 2] > 1.0


def test_the_particles_find_it_too() -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0), ParticleErrors(start_heading=math.inf))
    assert not localizer.heading_known
    seconds, off = driven_until_known(localizer, REFERENCE_NOISE, 3)
    assert seconds < 40.0
    assert off < math.radians(12.0)


def test_particles_that_are_elsewhere_start_again() -> None:
    """One outlier of 30 m at the start kept them there for half an hour."""
    log = record_course(straight_course(6), REFERENCE_NOISE, 5)
    localizer = ParticleFilter(Pose2(30.0, -20.0, 0.5))
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    for row in range(len(log.rates)):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if row in fixes:
            localizer.fix(fixes[row])
    assert localizer.restarts >= 1
    assert localizer.pose.distance(Pose2(*log.drive.poses[-1].tolist())) < 2.0


class Drive(NamedTuple):
    """A bank, or a filter, after a drive, and where the base is then."""

    bank: HeadingBank
    truth: Pose2


def driven(
    bias: float, heading: float, odd: int = 0, stretched: float = 1.0, away: Away = no_error, seed: int = 5
) -> Drive:
    """A bank with 60 fixes of a drive at 5 m/s, one a second.

    Odometry turns by `bias` [rad/s] more than the base; for the first `odd` seconds it read `stretched` times
    the way. `away` is what a fix is off besides its white error, by its number.
    """
    rng = np.random.default_rng(seed)
    noise = REFERENCE_NOISE._replace(
        antenna=(0.0, 0.0, 0.0), gyro_bias=math.radians(1.0), start_heading=math.inf
    )
    bank, truth = HeadingBank(Pose2(0.0, 0.0, 0.0), noise, 2.0), Pose2(0.0, 0.0, heading)
    odometry = GyroOdometry()
    for second in range(60):
        turn, way = 0.005 * math.sin(0.3 * second), stretched if second < odd else 1.0
        for _ in range(10):
            truth = truth.compose(Pose2(0.5, 0.0, turn))
            bank.advance(Advance(0.5 * way, turn + 0.1 * bias, 0.0, 0.1, 0.0, 0.0))
        bank.fix(np.array(truth[:2]) + rng.standard_normal(2) + away(second), 1.0, odometry)
    return Drive(bank, truth)


@pytest.mark.parametrize("heading", [0.0, 2.0, -3.0])
@pytest.mark.parametrize("bias", [-1.5, 0.0, 1.5])
def test_a_biased_gyro_bends_the_track(heading: float, bias: float) -> None:
    bank, truth = driven(math.radians(bias), heading)
    assert bank.is_known(KNOWN_HEADING_SIGMA_RAD)
    mean, covariance = bank.belief
    off = np.array([mean[0] - truth.x, mean[1] - truth.y, wrap(float(mean[2]) - truth.theta)])
    assert off @ np.linalg.solve(covariance[:3, :3], off) < 14.2  # 99.7 %
    assert abs(off[2]) < math.radians(6.0)


def test_odometry_that_was_wrong_at_first_is_forgotten() -> None:
    bank, truth = driven(0.0, 1.0, odd=12, stretched=1.8)
    assert abs(wrap(bank.pose.theta - truth.theta)) < math.radians(6.0)
    assert bank.pose.distance(truth) < 4.0


@pytest.mark.parametrize("seed", range(4))
def test_fixes_that_are_off_together_at_first_mislead_for_a_moment(seed: int) -> None:
    """A jump against the direction of travel looks like the opposite heading."""
    back = np.array([-25.0, 0.0])
    bank, truth = driven(0.0, 0.0, away=lambda second: back * (second in range(3, 8)), seed=seed)
    assert abs(wrap(bank.pose.theta - truth.theta)) < math.radians(6.0)
    assert bank.pose.distance(truth) < 3.0


def test_slow_errors_of_the_fixes_cancel_within_a_minute() -> None:
    """Two metres of slow error cost nothing: they are the same from fix to fix."""
    still, slow = (
        driven(0.0, 0.7, away=item).bank for item in (no_error, lambda second: np.array([2.0, -2.0]))
    )
    one, other = (bank.belief.covariance[2, 2] for bank in (still, slow))
    assert abs(wrap(still.pose.theta - slow.pose.theta)) < 0.01
    assert one == pytest.approx(other, rel=0.3)


def test_the_place_follows_the_fixes_while_the_heading_is_open() -> None:
    rng = np.random.default_rng(2)
    localizer = GpsFilter(
        Pose2(0.0, 0.0, 0.0), REFERENCE_NOISE._replace(start_heading=math.inf), 3.0, heading_sigma=1e-3
    )
    truth, most = Pose2(0.0, 0.0, 2.0), 0.0
    for _fix in range(40):
        for _ in range(20):
            truth = truth.compose(Pose2(0.05, 0.0, 0.0))
            localizer.predict(np.zeros(3), np.array([0.0, 0.0, 9.81]), np.full(2, 0.05), 0.05)
        localizer.fix(np.array(truth[:2]) + rng.standard_normal(2))
        meanwhile = localizer.meanwhile
        assert meanwhile is not None
        off = meanwhile.mean[:2] - np.array(truth[:2])
        assert off @ np.linalg.solve(meanwhile.covariance[:2, :2], off) < 20.0
        most = max(most, float(np.hypot(*off)))
    assert not localizer.heading_known
    assert most < 5.0
    assert localizer.pose.distance(truth) > 20.0  # by wheels and gyros alone, as a robot needs it


def test_a_track_needs_its_heading_less_exactly_than_a_sensor() -> None:
    loose, strict = (
        GpsFilter(Pose2(0.0, 0.0, 0.0), REFERENCE_NOISE._replace(start_heading=math.inf), heading_sigma=sigma)
        for sigma in (math.radians(10.0), math.radians(2.0))
    )
    first, second = (driven_until_known(item, REFERENCE_NOISE, 3)[0] for item in (loose, strict))
    assert first < second
    assert math.sqrt(loose.covariance[2, 2]) <= math.radians(10.5)


def test_a_worse_sky_moves_the_place_as_much_as_its_fixes_err() -> None:
    """Fixes see place and slow error together: their sum is as sure by each hypothesis."""
    localizer = GpsFilter(Pose2(0.0, 0.0, 0.0), REFERENCE_NOISE._replace(start_heading=math.inf))
    driven_until_known(localizer, REFERENCE_NOISE, 3)
    spreads = [filter_.belief.covariance for filter_ in localizer.filters]
    sums = [spread[X, X] + 2.0 * spread[X, GPS_X] + spread[GPS_X, GPS_X] for spread in spreads]
    assert max(sums) == pytest.approx(min(sums), rel=1e-6)
    assert max(spread[X, X] for spread in spreads) > 2.0 * min(spread[X, X] for spread in spreads)
