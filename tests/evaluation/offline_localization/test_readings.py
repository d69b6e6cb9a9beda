"""Sensors whose readings contradict each other; `benchmarks.damage.sensor_faults` plants more."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from benchmarks.damage.sensor_faults import SENSOR_FAULTS, reports, wheels_stand
from benchmarks.field.foreign_logs import record_foreign
from handcart.evaluation.offline_localization.checks.readings import check_readings, way_scale
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog


@cache
def recorded(name: str) -> DriveLog:
    return record_foreign(name, 3, 90.0).log


@pytest.mark.parametrize("name", [name for name, (_, words) in SENSOR_FAULTS.items() if words])
def test_a_planted_sensor_fault_is_reported(name: str) -> None:
    fault, words = SENSOR_FAULTS[name]
    assert any(words in note for note in reports(fault(recorded("truck"))))


@pytest.mark.parametrize("name", [name for name, (_, words) in SENSOR_FAULTS.items() if not words])
def test_a_good_or_parked_vehicle_has_no_note(name: str) -> None:
    assert reports(SENSOR_FAULTS[name][0](recorded("truck"))) == []


def test_wheels_that_stand_are_reported_with_count_and_time() -> None:
    (note,) = check_readings(wheels_stand(recorded("mower")))[1]
    assert "in 900 readings" in note
    assert "first after 45.0 s" in note
    assert "allowed: 6 m beside wheels that stand" in note


def test_a_jump_beside_a_parked_vehicle_is_no_travel() -> None:
    log = SENSOR_FAULTS["parked"][0](recorded("mower"))
    fixes = log.fixes.copy()
    fixes[1200:1300] += 15.0
    assert reports(log._replace(fixes=fixes)) == []


def test_repeated_fixes_are_left_out() -> None:
    frozen = SENSOR_FAULTS["receiver freezes"][0](recorded("mower"))
    left = check_readings(frozen)[0].fixes
    assert np.isfinite(left[:, 0]).sum() == 46  # [fixes] of 90: those of 45 s, and the one that is repeated


def test_the_way_scale_finds_the_unit() -> None:
    scale = way_scale(SENSOR_FAULTS["mm as m"][0](recorded("truck")))
    assert scale == pytest.approx(1e-3, rel=0.1)
