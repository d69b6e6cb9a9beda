"""A start whose heading nobody told; `benchmarks.field.headings` has more runs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.field.field_course import straight_course
from benchmarks.field.field_drive import PERIOD, FieldTimes
from benchmarks.field.field_log import record_course
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE, RTK, FieldNoise
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.heading_search import MOST, HeadingSearch, _biases
from handcart.robotics.navigation.outdoors.particle_filter import ParticleErrors, ParticleFilter


def driven_until_known(localizer: FieldLocalizer, noise: FieldNoise, seed: int) -> tuple[float, float]:
    """Seconds of driving after which the heading is known, and how far it is off then, in [rad]."""
    log = record_course(straight_course(3), noise, seed, FieldTimes(wait=10.0, dwell=5.0))
    fixes, drove = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True)), 0.0
    for row in range(len(log.rates)):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD)
        if row in fixes:
            localizer.fix(fixes[row])
        drove += PERIOD * bool(log.drive.driven[row, 0] > 0.0)
        if localizer.heading_known:
            return drove, abs(wrap(localizer.pose.theta - float(log.drive.poses[row, 2])))
    return math.inf, math.inf


def log_pose(noise: FieldNoise, seed: int, seconds: float) -> list[float]:
    """Where the base is after so many seconds of driving."""
    drive = record_course(straight_course(3), noise, seed, FieldTimes(wait=10.0, dwell=5.0)).drive
    row = int(np.searchsorted(np.cumsum(drive.driven[:, 0] > 0.0) * PERIOD, seconds - 1e-9))
    pose: list[float] = drive.poses[row].tolist()
    return pose


@pytest.mark.parametrize("noise", [REFERENCE, RTK], ids=["white 1 m", "RTK"])
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
    noise = REFERENCE._replace(outliers=0.1, outlier=30.0)
    localizer = GpsFilter(Pose2(0.0, 0.0, 1.0), REFERENCE._replace(start_heading=math.inf))
    seconds, off = driven_until_known(localizer, noise, 4)
    assert seconds < 60.0
    assert off < math.radians(12.0)


def test_standing_still_tells_no_heading() -> None:
    localizer = GpsFilter(Pose2(5.0, 7.0, 0.0), REFERENCE._replace(start_heading=math.inf))
    rng = np.random.default_rng(0)
    for _ in range(120):
        localizer.predict(np.zeros(3), np.array([0.0, 0.0, 9.81]), np.zeros(2), 1.0)
        localizer.fix(np.array([5.0, 7.0]) + rng.standard_normal(2))
    assert not localizer.heading_known
    assert localizer.covariance[2, 2] == pytest.approx(math.pi**2 / 3.0)


def test_the_particles_find_it_too() -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0), ParticleErrors(start_heading=math.inf))
    assert not localizer.heading_known
    seconds, off = driven_until_known(localizer, REFERENCE, 3)
    assert seconds < 40.0
    assert off < math.radians(12.0)


def test_particles_that_are_elsewhere_start_again() -> None:
    """One outlier of 30 m at the start kept them there for half an hour."""
    log = record_course(straight_course(6), REFERENCE, 5)
    localizer = ParticleFilter(Pose2(30.0, -20.0, 0.5))
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    for row in range(len(log.rates)):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD)
        if row in fixes:
            localizer.fix(fixes[row])
    assert localizer.restarts >= 1
    assert localizer.pose.distance(Pose2(*log.drive.poses[-1].tolist())) < 2.0


def driven(
    bias: float, heading: float, odd: int = 0, stretched: float = 1.0
) -> tuple[HeadingSearch, Pose2, Pose2]:
    """A search with 60 fixes of a drive, one a second; where odometry has the base, and the truth.

    Odometry turns by `bias` [rad/s] more than the base; for the first `odd` seconds it told
    `stretched` times the way.
    """
    rng, search = np.random.default_rng(5), HeadingSearch()
    truth, reckoned = Pose2(0.0, 0.0, heading), Pose2(0.0, 0.0, 0.0)
    for second in range(60):
        turn, way = 0.005 * math.sin(0.3 * second), stretched if second < odd else 1.0
        for _ in range(10):
            truth = truth.compose(Pose2(0.5, 0.0, turn))
            reckoned = reckoned.compose(Pose2(0.5 * way, 0.0, turn + 0.1 * bias))
        search.take(np.array(reckoned[:2]), np.array(truth[:2]) + rng.standard_normal(2), second + 1.0)
        if second < 59:
            search.found(reckoned, 1.0, 0.1, math.radians(1.0))
    return search, reckoned, truth


@pytest.mark.parametrize("heading", [0.0, 2.0, -3.0])
@pytest.mark.parametrize("bias", [-1.5, 0.0, 1.5])
def test_a_biased_gyro_bends_the_track(heading: float, bias: float) -> None:
    search, reckoned, truth = driven(math.radians(bias), heading)
    found = search.found(reckoned, 1.0, 0.1, math.radians(1.0))
    assert found is not None
    off = np.array([found.pose.x - truth.x, found.pose.y - truth.y, wrap(found.pose.theta - truth.theta)])
    assert off @ np.linalg.solve(found.covariance, off) < 14.2  # 99.7 %
    assert abs(off[2]) < math.radians(6.0)


def test_a_gyro_whose_bias_is_known_bends_nothing() -> None:
    """What nobody allowed for shows as a track that doesn't fit, or is far off."""
    search, reckoned, truth = driven(math.radians(1.5), 1.0)
    found = search.found(reckoned, 1.0, 0.1, 0.0)
    assert found is None or abs(wrap(found.pose.theta - truth.theta)) > math.radians(10.0)


def test_odometry_that_was_wrong_at_first_is_forgotten() -> None:
    search, reckoned, truth = driven(0.0, 1.0, odd=12, stretched=1.8)
    found = search.found(reckoned, 1.0, 0.1, math.radians(0.1))
    assert found is not None
    assert abs(wrap(found.pose.theta - truth.theta)) < math.radians(6.0)
    assert found.pose.distance(truth) < 4.0


def test_no_bias_is_tried_where_it_would_turn_nothing() -> None:
    """A base that stood knows its gyro: one heading costs no more than before."""
    assert len(_biases(math.radians(0.001), 100.0)) == 1
    assert len(_biases(math.radians(1.0), 10.0)) == 61
    assert len(_biases(math.radians(1.0), 1e4)) == 2 * MOST + 1
