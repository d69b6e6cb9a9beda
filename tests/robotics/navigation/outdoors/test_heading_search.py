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
