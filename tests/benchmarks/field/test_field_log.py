from __future__ import annotations

import numpy as np
import pytest

from benchmarks.field.field_course import (
    FieldCourse,
    straight_course,
    zigzag_course,
)
from benchmarks.field.field_drive import PERIOD_S, FieldTimes
from benchmarks.field.field_log import record_course
from benchmarks.field.placement_radius import TARGET_OFFSET_M
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE


@pytest.mark.parametrize("course", [straight_course(5), zigzag_course()])
def test_the_base_stops_with_each_target_on_its_right(course: FieldCourse) -> None:
    drive = record_course(course, REFERENCE_NOISE, 3).drive
    x, y, heading = drive.poses[drive.placings].T
    tip = np.column_stack([x + TARGET_OFFSET_M * np.sin(heading), y - TARGET_OFFSET_M * np.cos(heading)])
    assert np.abs(tip - course.targets).max() < 0.15
    assert (drive.driven[drive.placings, 0] == 0.0).all()


def test_errors_are_as_large_as_stated() -> None:
    logs = [record_course(zigzag_course(), REFERENCE_NOISE, seed) for seed in range(12)]
    tilts = np.degrees([log.drive.tilts[log.drive.driven[:, 0] > 0.0].std() for log in logs])
    assert 2.0 < np.mean(tilts) < 3.0
    fixes = np.concatenate([log.fixes - log.drive.poses[log.fix_rows, :2] for log in logs])
    assert 0.95 < fixes.std() < 1.05
    assert max(np.abs(log.drive.driven[:, 1]).max() for log in logs) <= 0.5 + 1e-9
    missed: list[float] = []  # by wheels, a leg
    for log in logs:
        wrong = np.cumsum(log.wheels.mean(axis=1) - log.drive.driven[:, 0])
        missed.extend(np.diff(wrong[log.drive.placings]))
    assert 0.3 < np.std(missed) < 0.5  # 12 % of a turn, and of swinging back onto the line


def test_the_same_seed_gives_the_same_log() -> None:
    first, again, other = (record_course(straight_course(2), REFERENCE_NOISE, seed) for seed in (5, 5, 6))
    assert np.array_equal(first.rates, again.rates)
    assert np.array_equal(first.fixes, again.fixes)
    assert not np.array_equal(first.fixes, other.fixes)


def test_outages_and_reflections_come_in_spells() -> None:
    times = FieldTimes(wait=3600.0)
    silent = REFERENCE_NOISE._replace(outage_every=120.0, outage_time=60.0)
    log = record_course(straight_course(1), silent, 0, times)
    gaps = np.diff(log.fix_rows) * PERIOD_S
    assert gaps.max() > 30.0
    assert 0.5 < len(log.fixes) * 1.0 / (len(log.rates) * PERIOD_S) < 0.85
    shifted = REFERENCE_NOISE._replace(multipath_every=120.0, gps_white=0.01)
    log = record_course(straight_course(1), shifted, 0, times)
    off = np.abs(log.fixes - log.drive.poses[log.fix_rows, :2]).max(axis=1) > 0.5
    assert 0.05 < off.mean() < 0.3


def test_drift_of_fixes_has_its_size_and_its_time() -> None:
    noise = REFERENCE_NOISE._replace(
        gps_white=1e-6, gps_drift=0.5, gps_drift_time=50.0, antenna=(0.0, 0.0, 0.0)
    )
    log = record_course(straight_course(1), noise, 1, FieldTimes(wait=20000.0))
    off = (log.fixes - log.drive.poses[log.fix_rows, :2])[:, 0]
    assert 0.4 < off.std() < 0.6
    assert np.corrcoef(off[50:], off[:-50])[0, 1] == pytest.approx(np.exp(-1.0), abs=0.12)
