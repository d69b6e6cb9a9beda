"""Monitors of fixes, slip and ways: at which value each of them changes its mind."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.slip_monitor import SlipMonitor, turn_variance
from handcart.robotics.navigation.odometry.way_monitor import WayMonitor
from handcart.robotics.navigation.outdoors.fix_monitor import FixMonitor, whitened
from handcart.robotics.navigation.outdoors.lost_track import LostTrack

ONE = np.eye(2)
FORECAST = 0.5 * ONE


def test_whitening_leaves_the_squared_distance() -> None:
    residual, covariance = np.array([0.7, -1.2]), np.array([[2.0, 0.6], [0.6, 0.5]])
    white = whitened(residual, covariance)
    assert white @ white == pytest.approx(residual @ np.linalg.solve(covariance, residual))
    assert white[0] == pytest.approx(0.7 / math.sqrt(2.0))


@pytest.mark.parametrize(("away", "count"), [(4.99, 0), (5.01, 1), (-5.01, 1)])
def test_one_fix_is_suspect_beyond_five_sigmas(away: float, count: int) -> None:
    monitor = FixMonitor()
    assert monitor.suspects(np.array([2.0 * away, 0.0]), 4.0 * ONE) == count
    assert not monitor.doubting


def test_fixes_off_together_are_suspect_from_the_first_of_them() -> None:
    """k fixes of s sigmas each sum up to k s²: 9 of 1.7 are 26; two good ones before do not matter."""
    monitor, found = FixMonitor(), []
    for away in (0.0, 0.0, *[1.7] * 9):
        assert not monitor.doubting
        found.append(monitor.suspects(np.array([0.0, away]), ONE))
    assert found == [0] * 10 + [9]
    assert monitor.doubting
    monitor.reset()
    assert not monitor.doubting
    assert [monitor.suspects(np.array([0.0, 1.7]), ONE) for _ in range(9)] == [0] * 8 + [9]


def test_fixes_are_summed_over_the_last_two_dozen() -> None:
    """24 of 1.01 sigmas are 24.5, and no number of them is more than the 25 allowed."""
    monitor = FixMonitor()
    assert {monitor.suspects(np.array([1.01, 0.0]), ONE) for _ in range(60)} == {0}
    monitor = FixMonitor()
    assert next(k for k in range(1, 60) if monitor.suspects(np.array([1.03, 0.0]), ONE)) == 24


def test_a_doubt_is_over_after_five_good_fixes() -> None:
    monitor = FixMonitor()
    for _ in range(9):
        monitor.suspects(np.array([1.7, 0.0]), ONE)
    assert monitor.doubting
    bad, good = np.array([7.0, 0.0]), np.array([0.1, 0.0])
    found = [monitor.cleared(item, FORECAST, 1.0) for item in (good, good, bad, good, good, good, good)]
    assert found == [False] * 7  # five with a bad one among them are not good
    assert monitor.cleared(good, FORECAST, 1.0)
    assert not monitor.doubting
    assert monitor.suspects(np.array([1.7, 0.0]), ONE) == 0  # the past is forgotten


@pytest.mark.parametrize("factor", [0.999, 1.001])
def test_a_doubt_holds_where_the_mean_is_three_sigmas_off(factor: float) -> None:
    limit = 3.0 * math.sqrt(0.5 + 1.0 / 5.0)
    monitor = FixMonitor()
    found = [monitor.cleared(np.array([0.0, factor * limit]), FORECAST, 1.0) for _ in range(5)]
    assert found == [False] * 4 + [factor < 1.0]


@pytest.mark.parametrize("factor", [0.999, 1.001])
def test_a_doubt_holds_where_one_fix_is_five_sigmas_off(factor: float) -> None:
    away = factor * 5.0 * math.sqrt(1.5)
    monitor = FixMonitor()
    residuals = (away, -away, 0.0, away, -away)
    found = [monitor.cleared(np.array([residual, 0.0]), FORECAST, 1.0) for residual in residuals]
    assert found[-1] == (factor < 1.0)


def refused_along(turn: float, count: int, step: float = 1.0, shift: float = 0.0) -> LostTrack:
    """Fixes on a straight track that is turned or shifted from the odometry's, one each metre."""
    lost = LostTrack()
    lost.take(Pose2(0.0, 0.0, 0.0), np.zeros(2), True)
    for k in range(count):
        way = step * k
        place = np.array([way * math.cos(turn), way * math.sin(turn) + shift])
        lost.take(Pose2(way, 0.0, 0.0), place, False)
    return lost


def test_a_turned_track_is_found_from_ten_fixes_on() -> None:
    here = Pose2(8.0, 0.0, 0.0)
    assert refused_along(0.5, 9).found(0.1, here, 0.02) is None
    found = refused_along(0.5, 10).found(0.1, here, 0.02)
    assert found is not None
    assert found.pose == pytest.approx((9.0 * math.cos(0.5), 9.0 * math.sin(0.5), 0.5))
    reach = 82.5  # sum of squares of -4.5 to 4.5
    heading = 4.0 * 0.1**2 / reach + 0.02**2
    lever = np.array([-4.5 * math.sin(0.5), 4.5 * math.cos(0.5), 1.0])
    place = 4.0 * 0.1**2 / 10 + 1e-4
    assert found.covariance == pytest.approx(heading * np.outer(lever, lever) + np.diag([place, place, 0.0]))


@pytest.mark.parametrize("sigma", [0.1, 0.5])
@pytest.mark.parametrize("factor", [-1.01, -0.99, 0.99, 1.01])
def test_a_turn_is_proven_beyond_six_sigmas(factor: float, sigma: float) -> None:
    """Sigma of a turn over 9 m is at least 2 %, and what the fixes leave of it."""
    limit = 6.0 * math.sqrt(4.0 * sigma**2 / 82.5 + 0.02**2)
    found = refused_along(factor * limit, 10).found(sigma, Pose2(9.0, 0.0, 0.0), 0.02)
    assert (found is not None) == (abs(factor) > 1.0)


@pytest.mark.parametrize(("sigma", "is_found"), [(1.8, True), (1.83, False)])
def test_a_track_shorter_than_five_sigmas_tells_no_turn(sigma: float, is_found: bool) -> None:
    lost = refused_along(2.5, 10)
    assert (5.0 * sigma < 9.083) == is_found
    assert (lost.found(sigma, Pose2(9.0, 0.0, 0.0), 0.02) is not None) == is_found


@pytest.mark.parametrize(("scatter", "is_found"), [(0.31, True), (0.33, False)])
def test_fixes_that_do_not_agree_turn_nothing(scatter: float, is_found: bool) -> None:
    """Up to 1.4 sigmas and 2 % of the way."""
    lost = LostTrack()
    for k in range(10):
        aside = scatter * math.sqrt(2.0) * (1.0 if k in (0, 3, 5, 6, 9) else -1.0)
        lost.take(Pose2(float(k), 0.0, 0.0), np.array([aside, float(k)]), False)
    assert pytest.approx(0.32) == 1.4 * 0.1 + 0.02 * 9.0
    assert (lost.found(0.1, Pose2(9.0, 0.0, 0.0), 0.02) is not None) == is_found


@pytest.mark.parametrize(("count", "is_found"), [(199, False), (200, True)])
def test_a_shift_is_believed_after_two_hundred_fixes(count: int, is_found: bool) -> None:
    lost = refused_along(0.0, count, 0.01, shift=3.0)
    found = lost.found(0.5, Pose2(5.0, 1.0, 0.0), 0.02)
    assert (found is not None) == is_found
    if found is None:
        return
    last = 0.01 * (count - 1)
    assert found.pose == pytest.approx((last, 3.0, 0.0))
    assert found.covariance == pytest.approx(np.diag([0.25, 0.25, math.radians(3.0) ** 2]))


def test_fixes_that_are_believed_no_more_count_as_refused() -> None:
    lost = LostTrack()
    for k in range(12):
        lost.take(Pose2(float(k), 0.0, 0.0), np.array([0.0, float(k)]), k < 4)
    assert lost.found(0.1, Pose2(11.0, 0.0, 0.0), 0.02) is None
    lost.doubt(1)
    assert lost.found(0.1, Pose2(11.0, 0.0, 0.0), 0.02) is None
    lost.doubt(1)
    assert lost.found(0.1, Pose2(11.0, 0.0, 0.0), 0.02) is not None


def windows(
    monitor: SlipMonitor, count: int, missed: float, other: float = 0.0, variance: float = 1e-4
) -> float:
    for _ in range(count):
        monitor.roll(-0.2, 0.1, 0.5 * variance)
        monitor.take(0.5 * missed, other)
        monitor.roll(0.05, 0.1, 0.5 * variance)
        monitor.take(0.5 * missed, other)
    return monitor.factor


def test_slip_is_learned_from_three_windows_of_30_cm() -> None:
    monitor = SlipMonitor()
    assert monitor.begun
    assert windows(monitor, 2, 0.1) == 1.0
    assert monitor.begun
    ratio = (0.1**2 - 2.0 * 0.003**2) / 1e-4
    assert windows(monitor, 1, 0.1) == pytest.approx(ratio)
    assert windows(monitor, 3, 0.0) == pytest.approx(0.5 * ratio)
    assert windows(monitor, 4, 0.1) == pytest.approx(0.7 * ratio)
    assert windows(monitor, 3, 0.1) == pytest.approx(0.7 * ratio)  # ten windows: the first three are gone
    assert windows(monitor, 3, 0.1) == pytest.approx(ratio)


def test_slip_other_reasons_and_limits_count() -> None:
    assert windows(SlipMonitor(), 3, 0.1, other=0.004) == pytest.approx((0.006 - 2.0 * 0.003**2) / 1e-4)
    assert windows(SlipMonitor(), 3, -10.0) == 400.0
    assert windows(SlipMonitor(), 3, 0.001) == 1.0
    begun = SlipMonitor()
    windows(begun, 3, 0.1)
    begun.roll(0.2, 0.2, 1e-4)
    begun.take(5.0, 0.0)
    assert not begun.begun
    begun.begin()
    assert begun.begun
    assert windows(begun, 1, 0.1) == pytest.approx((0.1**2 - 2.0 * 0.003**2) / 1e-4)


def test_slip_turns_by_both_wheels_over_the_tread() -> None:
    assert turn_variance(0.02, 0.1, -0.3, 0.1, 0.5) == pytest.approx(0.02**2 * 0.1 * 0.4 / 0.25)
    assert turn_variance(0.02, 0.1, math.inf, 0.1, 0.5) == 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_a_way_is_wrong_beyond_three_sigmas(factor: float, sign: float) -> None:
    monitor = WayMonitor()
    limit = 3.0 * math.sqrt(2.0 * 0.01**2 + 2.0 * 1e-4 + 1e-3 * 0.6**2)
    for k in range(2):
        monitor.roll(sign * 0.3, 1e-4)
        found = monitor.take(0.5 * factor * limit, 0.01, 1e-3)
        assert k or found == 0.0
    assert found == (pytest.approx(factor * limit / 0.6) if factor > 1.0 else 0.0)


def test_a_way_is_tested_each_half_metre_for_ten_metres() -> None:
    monitor, found = WayMonitor(), []
    monitor.roll(0.5, 0.0)
    assert monitor.take(0.0, 0.01, 0.0) == 0.0
    for way in (0.4, 0.1):
        monitor.roll(way, 0.0)
        found.append(monitor.take(0.05, 0.01, 0.0))
    assert found == pytest.approx([0.0, 0.1])
    monitor.roll(0.45, 0.0)  # a window of its own
    assert monitor.take(1.0, 0.01, 0.0) == 0.0
    monitor.begin()
    for way, missed in ((10.0, 0.0), (0.6, 0.0), (0.6, 0.05)):
        monitor.roll(way, 0.0)
        found.append(monitor.take(missed, 0.01, 0.0))
    assert found[2:] == pytest.approx([0.0, 0.0, 0.05 / 0.6])
