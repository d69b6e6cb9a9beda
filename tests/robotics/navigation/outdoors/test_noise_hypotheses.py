"""Claims of a filter in a world that differs from its model; `benchmarks.field.mismatches` has more runs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.field.field_course import straight_course, zigzag_course
from benchmarks.field.field_log import record_course
from benchmarks.field.field_trial import start_pose, try_course
from benchmarks.field.mismatches import NOISE_WORLDS
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.noise_hypotheses import NoiseHypothesis, noise_hypotheses
from handcart.robotics.navigation.outdoors.placement_errors import nees


def squares(world: str, seeds: range, alone: bool = False) -> np.ndarray:
    """Of all placements in some runs; `alone`: nothing but what is told is supposed."""
    supposed = [NoiseHypothesis(REFERENCE_NOISE, 1.0, 0)] if alone else None
    found = []
    for seed in seeds:
        log = record_course((straight_course, zigzag_course)[seed % 2](5), NOISE_WORLDS[world], seed)
        trial = try_course(log, GpsFilter(start_pose(log), supposed=supposed))
        found.append(nees(trial.errors, trial.covariances))
    return np.concatenate(found)


@pytest.mark.slow
@pytest.mark.parametrize("world", ["drift", "antenna", "heading", "slip"])
def test_claims_hold_where_the_world_is_not_as_told(world: str) -> None:
    seeds = range(4)
    assert squares(world, seeds).mean() < 4.0
    assert squares(world, seeds, alone=True).mean() > 4.0


@pytest.mark.slow
def test_what_the_world_is_like_is_found_out() -> None:
    before = GpsFilter(start_pose(record_course(straight_course(1), REFERENCE_NOISE, 0))).weights
    for world, rows in (("as told", slice(0, 1)), ("jumps", slice(9, 12))):
        log = record_course(straight_course(6), NOISE_WORLDS[world], 2)
        localizer = GpsFilter(start_pose(log))
        try_course(log, localizer)
        assert localizer.weights[rows].sum() > before[rows].sum() + 0.1


def test_hypotheses_that_are_apart_are_unsure() -> None:
    localizer = GpsFilter(start_pose(record_course(straight_course(1), REFERENCE_NOISE, 0)))
    near = localizer.covariance[0, 0]
    localizer.filters[1]._mean[0] += 2.0
    localizer.forget_derived()
    share = localizer.weights[1]
    assert localizer.covariance[0, 0] == pytest.approx(near + 4.0 * share * (1.0 - share))
    assert localizer.pose.x == pytest.approx(2.0 * share, abs=1e-6)


def test_fixes_twice_as_far_off_as_they_may_be_contradict_the_claim() -> None:
    """Each could be, all of them can't."""
    start = start_pose(record_course(straight_course(1), REFERENCE_NOISE, 0))
    localizer = GpsFilter(start, supposed=[NoiseHypothesis(REFERENCE_NOISE, 1.0, 0)])
    rng = np.random.default_rng(3)
    for _ in range(60):
        localizer.predict(np.zeros(3), np.array([0.0, 0.0, 9.81]), np.zeros(2), 1.0)
        localizer.fix(2.0 * rng.standard_normal(2))
    found = localizer.inconsistency
    assert found is not None
    assert found.what == "mean square of their errors, in sigmas"
    assert found.value > found.limit


def test_worlds_become_worse_and_never_better() -> None:
    localizer = GpsFilter(start_pose(record_course(straight_course(1), REFERENCE_NOISE, 0)))
    given, worse = noise_hypotheses(REFERENCE_NOISE)[0], noise_hypotheses(REFERENCE_NOISE)[3]
    assert given.may_become(worse)
    assert not worse.may_become(given)
    assert localizer._becomes[0].tolist() == [1.0] + [0.0] * 11


@pytest.mark.slow
def test_fixes_that_come_late_are_found_to() -> None:
    log = record_course(straight_course(8), NOISE_WORLDS["delay"], 1)
    localizer = GpsFilter(start_pose(log))
    try_course(log, localizer)
    delay = float(localizer.best.belief.mean[12])
    assert delay == pytest.approx(0.5, abs=0.35)
    assert delay > 0.15


@pytest.mark.slow
def test_wheels_that_creep_stand_still() -> None:
    """1 mm/s from the wheels of a base that stands: the gyros' bias is learned all the same."""
    creeping, still = squares("creep", range(2)), squares("as told", range(2))
    assert creeping.mean() == pytest.approx(still.mean(), rel=0.5)


def test_turning_slowly_on_the_spot_is_no_creep() -> None:
    from handcart.robotics.navigation.outdoors.gyro_odometry import GyroOdometry

    odometry = GyroOdometry()
    rng = np.random.default_rng(0)
    up = np.array([0.0, 0.0, 9.81])
    for period in range(1200):
        turns = 0.0 if period < 600 else math.radians(1.0)
        rolled = 0.3 * turns * 0.025
        rates = np.array([0.0, 0.0, turns]) + 1e-3 * rng.standard_normal(3)
        odometry.update(rates, up + 0.02 * rng.standard_normal(3), np.array([-rolled, rolled]), 0.025)
    assert odometry.pose.theta == pytest.approx(math.radians(15.0), abs=math.radians(1.0))


def test_a_minute_of_fixes_far_off_is_an_inconsistency() -> None:
    localizer = GpsFilter(start_pose(record_course(straight_course(1), REFERENCE_NOISE, 0)), REFERENCE_NOISE)
    rng = np.random.default_rng(1)
    for _ in range(30):
        assert localizer.inconsistency is None
        localizer.predict(np.zeros(3), np.array([0.0, 0.0, 9.81]), np.zeros(2), 1.0)
        localizer.fix(rng.standard_normal(2))
    for count in range(60):
        localizer.predict(np.zeros(3), np.array([0.0, 0.0, 9.81]), np.zeros(2), 1.0)
        localizer.fix(np.array([40.0 * (-1) ** count, 60.0 * (count % 3)]))
    found = localizer.inconsistency
    assert found is not None
    assert found.value > found.limit
