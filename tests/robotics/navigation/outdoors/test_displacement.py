"""Displacement of the base since a moment, which is known better than its position."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.field.displacements import Way, true_way, ways
from benchmarks.field.field_course import straight_course
from benchmarks.field.field_drive import PERIOD_S
from benchmarks.field.field_log import FieldLog, record_course
from benchmarks.field.field_trial import start_pose
from handcart.backends.plain_values import attributes, set_attributes
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.gyro_only import GyroOnly
from handcart.robotics.navigation.outdoors.noise_hypotheses import NoiseHypothesis
from handcart.robotics.navigation.outdoors.particle_filter import ParticleFilter
from handcart.robotics.navigation.outdoors.placement_errors import nees

STANDS = 2400  # periods at first


@pytest.fixture(scope="module")
def log() -> FieldLog:
    return record_course(straight_course(2), REFERENCE_NOISE, 5)


def localizers(log: FieldLog) -> list[FieldLocalizer]:
    start = start_pose(log)
    return [GpsFilter(start), GyroOnly(start, REFERENCE_NOISE, 0.05), ParticleFilter(start)]


def play(log: FieldLog, localizer: FieldLocalizer, begin: int, end: int) -> None:
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    for row in range(begin, end):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if row in fixes:
            localizer.fix(fixes[row])


@pytest.mark.parametrize("number", range(3))
def test_while_it_stands_it_has_come_nowhere_whatever_fixes_say(log: FieldLog, number: int) -> None:
    localizer = localizers(log)[number]
    play(log, localizer, 0, STANDS // 2)
    localizer.set_origin()
    before = localizer.pose
    play(log, localizer, STANDS // 2, STANDS)
    mean, covariance = localizer.displacement
    assert np.abs(mean).max() < 1e-9
    assert np.abs(covariance).max() < 1e-9
    assert (localizer.pose.distance(before) > 0.001) == localizer.TAKES_FIXES


@pytest.mark.parametrize("number", range(3))
def test_it_is_the_way_that_was_driven(log: FieldLog, number: int) -> None:
    """Between two steps of the filter as well."""
    localizer = localizers(log)[number]
    end = int(log.drive.placings[0]) - 800  # it still drives
    play(log, localizer, 0, STANDS)
    localizer.set_origin()
    play(log, localizer, STANDS, end + 1)
    play(log, localizer, end + 1, end + 3)
    mean, covariance = localizer.displacement
    off = mean - true_way(log, STANDS - 1, end + 2)
    assert (np.abs(off) < 4.0 * np.sqrt(covariance.diagonal()) + 0.01).all()
    assert np.hypot(*mean[:2]) > 3.0


@pytest.mark.slow
def test_displacement_over_ten_metres_is_consistent_and_smaller() -> None:
    found: list[Way] = []
    for seed in range(6):
        found += ways(record_course(straight_course(4), REFERENCE_NOISE, seed), legs=1)
    errors = np.array([way.error for way in found])
    squares = nees(errors, np.array([way.covariance for way in found]))
    assert 0.5 < squares.mean() < 3.0
    assert (squares < 13.8).all()
    assert (errors**2).sum() < 0.7 * (np.array([way.pose_error for way in found]) ** 2).sum()


@pytest.mark.parametrize("origin", [1400, 1700])
def test_fixes_that_are_taken_back_are_taken_back_of_the_way_too(log: FieldLog, origin: int) -> None:
    """Set before, or among, fixes that are reflected, which shows only later: as if they hadn't come."""
    rows = (log.fix_rows > 1600) & (log.fix_rows < 2300)
    wrong = log._replace(fixes=log.fixes + 1.5 * rows[:, None])
    first, second = (
        GpsFilter(start_pose(log), supposed=[NoiseHypothesis(REFERENCE_NOISE, 1.0, 0)]) for _ in range(2)
    )
    play(wrong, first, 0, origin)
    first.set_origin()
    assert first.refused == 0
    play(wrong, first, origin, 1900)
    assert first.refused > 4
    play(wrong, first, 1900, 3000)
    none = rows | ((log.fix_rows >= 2300) & (log.fix_rows < 2440))  # waits until some are as expected
    heard = log._replace(fix_rows=log.fix_rows[~none], fixes=log.fixes[~none])
    play(heard, second, 0, origin)
    second.set_origin()
    play(heard, second, origin, 3000)
    for one, other in zip(first.displacement, second.displacement, strict=True):
        assert np.allclose(one, other, atol=1e-9)


def test_after_a_restart_nothing_is_known_to_cancel(log: FieldLog) -> None:
    """A filter that starts half a turn off notices that on the way; the fixes show how far that was."""
    end = int(log.drive.placings[1])
    localizer = GpsFilter(Pose2(0.0, 0.0, log.start_heading + math.pi))
    play(log, localizer, 0, STANDS)
    localizer.set_origin()
    play(log, localizer, STANDS, end)
    assert localizer.restarts > 0
    mean, covariance = localizer.displacement
    far = np.hypot(*mean[:2]) - np.hypot(*true_way(log, STANDS - 1, end - 1)[:2])
    assert abs(far) < 4.0 * math.sqrt(np.trace(covariance[:2, :2]))
    assert covariance[0, 0] > localizer.covariance[:2, :2].diagonal().min()


def test_before_the_heading_is_known_the_way_is(log: FieldLog) -> None:
    """The displacement counts from the start, whatever the heading was."""
    localizer = GpsFilter(Pose2(0.0, 0.0, 0.0), REFERENCE_NOISE._replace(start_heading=math.inf))
    play(log, localizer, 0, STANDS)
    localizer.set_origin()
    play(log, localizer, STANDS, STANDS + 300)
    assert not localizer.heading_known
    mean, covariance = localizer.displacement
    off = mean - true_way(log, STANDS - 1, STANDS + 299)
    assert (np.abs(off) < 4.0 * np.sqrt(covariance.diagonal()) + 0.01).all()
    assert mean[0] > 2.0
    assert math.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[-1]) < 0.15


def test_a_checkpoint_keeps_the_origin(log: FieldLog) -> None:
    first, second = (GpsFilter(start_pose(log)) for _ in range(2))
    play(log, first, 0, 900)
    first.set_origin()
    play(log, first, 900, 3000)
    parts = ((item, item.odometry, *item.parts) for item in (first, second))
    for before, after in zip(*parts, strict=True):
        set_attributes(after, after.STATE, attributes(before, before.STATE))
    second.forget_derived()
    for one, other in zip(first.displacement, second.displacement, strict=True):
        assert np.array_equal(one, other)


def test_without_an_origin_there_is_no_way() -> None:
    with pytest.raises(ValueError, match="no origin"):
        _ = GpsFilter(Pose2(0.0, 0.0, 0.0)).displacement
