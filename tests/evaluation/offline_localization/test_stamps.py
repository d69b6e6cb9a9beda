"""Invalid header stamps: zero, falling back, repeating, of another clock."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.evaluation.offline_localization.checks.stamps import check_offsets, check_stamps
from handcart.robotics.numerics.arrays import FloatArray

RECEIVED: FloatArray = np.asarray(1_700_000_000.0 + 0.05 * np.arange(400), dtype=np.float64)
LATE = 0.01


def test_good_stamps_are_used_without_a_note() -> None:
    jitter = 0.004 * np.random.default_rng(0).standard_normal(400)
    report = check_stamps("/imu", RECEIVED - LATE, RECEIVED + jitter)
    assert report.used.all()
    assert (report.notes, report.unusable) == ([], "")


@pytest.mark.parametrize(("zeros", "share"), [(400, "all"), (300, "300 of 400")])
def test_stamps_that_are_zero_are_counted_and_unusable(zeros: int, share: str) -> None:
    stamps = RECEIVED - LATE
    stamps[:zeros] = 0.0
    assert f"/imu: {share} stamps are zero" in check_stamps("/imu", stamps, RECEIVED).unusable


def test_some_zero_stamps_are_left_out_with_count_and_time() -> None:
    stamps = RECEIVED - LATE
    stamps[100:103] = 0.0
    report = check_stamps("/imu", stamps, RECEIVED)
    assert report.unusable == ""
    assert report.used.sum() == 397
    assert report.notes == ["/imu: 3 stamps are zero, first after 5.0 s; those messages are left out"]


@pytest.mark.parametrize("by", [-60.0, 60.0, -2.0, 3600.0])
def test_a_lasting_jump_is_unusable_and_told_with_its_time(by: float) -> None:
    stamps = RECEIVED - LATE
    stamps[200:] += by
    report = check_stamps("/odom", stamps, RECEIVED)
    assert report.unusable == f"/odom: stamps jump by {by:+.1f} s after 10.0 s"


def test_a_single_stamp_that_is_off_is_left_out() -> None:
    stamps = RECEIVED - LATE
    stamps[[50, 300]] += (400.0, -7.0)
    report = check_stamps("/odom", stamps, RECEIVED)
    assert report.unusable == ""
    assert np.flatnonzero(~report.used).tolist() == [50, 300]
    assert "2 stamps are off alone, first after 2.5 s" in report.notes[0]


def test_stamps_in_a_wrong_order_are_counted() -> None:
    stamps = RECEIVED - LATE
    stamps[[120, 121]] = stamps[[121, 120]]
    report = check_stamps("/odom", stamps, RECEIVED)
    assert report.unusable == ""
    assert "1 stamps fall back, first after 6.0 s, by 0.050 s at most" in report.notes[0]


def test_stamps_that_repeat_are_counted() -> None:
    stamps = RECEIVED - LATE
    stamps[201:211] = stamps[200]
    report = check_stamps("/imu", stamps, RECEIVED)
    assert "10 stamps repeat the one before, first after 10.0 s" in report.notes[0]


def test_a_recorder_that_stalls_is_no_jump() -> None:
    received = RECEIVED.copy()
    received[200:240] = received[240]  # the disk was busy for 2 s
    report = check_stamps("/imu", RECEIVED - LATE, received)
    assert report.unusable == ""
    assert report.used.all()


def test_a_bag_replayed_at_double_speed_has_no_jumps() -> None:
    received = RECEIVED[0] + 0.5 * (RECEIVED - RECEIVED[0])
    for every in (1, 20):  # 20 Hz, and a fix each second
        report = check_stamps("/fix", RECEIVED[::every], received[::every])
        assert (report.notes, report.unusable) == ([], "")


@pytest.mark.parametrize(
    ("delays", "note", "unusable"),
    [
        ({"/imu": 0.01, "/fix": 0.12}, False, False),
        ({"/imu": 0.01, "/fix": 0.51}, True, False),
        ({"/imu": 0.01, "/fix": -17.99}, False, True),
        ({"/imu": 0.01}, False, False),
    ],
)
def test_another_clock_is_told_from_a_delay(delays: dict[str, float], note: bool, unusable: bool) -> None:
    notes, why = check_offsets(delays)
    assert bool(notes) == note
    assert bool(why) == unusable
    assert ("18.00 s" in why) == unusable
