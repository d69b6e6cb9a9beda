from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.field.field_course import straight_course, zigzag_course
from benchmarks.field.field_drive import PERIOD_S
from benchmarks.field.field_log import FieldLog, record_course
from benchmarks.field.field_trial import as_laid, start_pose, try_course
from benchmarks.field.information_limit import information_limit
from benchmarks.field.placement_radius import tip_covariance
from handcart.backends.plain_values import to_plain
from handcart.backends.saved_state import pack
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE, RTK_NOISE, FieldNoise
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.noise_hypotheses import NoiseHypothesis
from handcart.robotics.navigation.outdoors.placement_errors import nees
from handcart.robotics.navigation.outdoors.smoothing import TrackRecord

RUNS = range(16)


def only(noise: FieldNoise) -> list[NoiseHypothesis]:
    """Return a filter with this hypothesis alone, whatever the fixes say."""
    return [NoiseHypothesis(noise, 1.0, 0)]


def limit(log: FieldLog) -> np.ndarray:
    """(k, 2) least variances of the tip, in [m²]."""
    bounds = information_limit(log.drive, log.fix_rows, REFERENCE_NOISE)
    headings = log.drive.poses[log.drive.placings, 2]
    return np.array([np.diag(tip_covariance(p, float(h))) for p, h in zip(bounds, headings, strict=True)])


def final_error(log: FieldLog, localizer: GpsFilter) -> float:
    """Distance to the truth after the last reading, in [m]; every pose on the way is finite."""
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    for row in range(len(log.rates)):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if row in fixes:
            localizer.fix(fixes[row])
        assert all(map(math.isfinite, localizer.pose))
    return localizer.pose.distance(Pose2(*log.drive.poses[-1].tolist()))


@pytest.mark.slow
def test_it_reaches_the_limit_and_knows_how_wrong_it_is() -> None:
    """Its errors, its own covariance, and the report afterwards; the benchmark has more runs."""
    live, later, bounds = [], [], []
    for seed in RUNS:
        log = record_course(zigzag_course(), REFERENCE_NOISE, seed)
        localizer = GpsFilter(start_pose(log), record=True)
        live.append(try_course(log, localizer))
        later.append(as_laid(log, localizer.smoothed()))
        bounds.append(limit(log))
    rms, rms_later = (
        np.sqrt(np.mean(np.concatenate([t.errors for t in ts]) ** 2, axis=0)) for ts in (live, later)
    )
    least = np.sqrt(np.concatenate(bounds).mean(axis=0))
    assert (rms < 1.25 * least).all()
    assert (rms_later < 0.9 * rms).all()
    for trials in (live, later):
        squares = np.concatenate([nees(t.errors, t.covariances) for t in trials])
        assert 0.9 < squares.mean() < 2.9  # claims lean to the safe side
        assert (squares < 5.991).mean() > 0.87


@pytest.mark.slow
def test_rtk_lays_within_three_centimetres() -> None:
    errors = []
    for seed in range(6):
        log = record_course(zigzag_course(), RTK_NOISE, seed)
        errors.append(np.hypot(*try_course(log, GpsFilter(start_pose(log), RTK_NOISE)).errors.T))
    assert np.quantile(errors, 0.95) < 0.035


@pytest.mark.slow
@pytest.mark.parametrize("noise", [REFERENCE_NOISE, RTK_NOISE])
@pytest.mark.parametrize("turn", [math.pi, -2.0, math.radians(40.0)])
def test_a_wrong_start_heading_is_found_out(noise: FieldNoise, turn: float) -> None:
    log = record_course(straight_course(3), noise, 2)
    localizer = GpsFilter(Pose2(0.0, 0.0, log.start_heading + turn), noise)
    assert final_error(log, localizer) < 1.0
    assert localizer.restarts >= 1
    assert abs(localizer.pose.theta - log.drive.poses[-1, 2]) < 4 * math.sqrt(localizer.covariance[2, 2])


@pytest.mark.slow
@pytest.mark.parametrize("shift", [2.5, 5.0, 30.0])
def test_reflection_is_rejected_and_its_effect_undone(shift: float) -> None:
    log = record_course(straight_course(4), REFERENCE_NOISE, 3)
    rows = (log.fix_rows > 4000) & (log.fix_rows < 5600)  # 40 s
    log.fixes[rows] += shift
    localizer = GpsFilter(start_pose(log), record=True)
    trial = try_course(log, localizer)
    assert localizer.refused > 0.8 * rows.sum()
    assert localizer.restarts == 0
    assert np.hypot(*trial.errors.T).max() < 0.7
    assert np.hypot(*as_laid(log, localizer.smoothed()).errors.T).max() < 0.5


@pytest.mark.slow
def test_good_fixes_are_believed() -> None:
    for seed in range(4):
        log = record_course(zigzag_course(), REFERENCE_NOISE, seed)
        localizer = GpsFilter(start_pose(log))
        try_course(log, localizer)
        assert localizer.refused == 0


@pytest.mark.slow
def test_an_outage_is_bridged_and_the_covariance_says_so() -> None:
    log = record_course(straight_course(3), REFERENCE_NOISE, 4)
    heard = (log.fix_rows < 2400) | (log.fix_rows > 4800)
    quiet = log._replace(fix_rows=log.fix_rows[heard], fixes=log.fixes[heard])
    spread = [try_course(one, GpsFilter(start_pose(one))).covariances[0].trace() for one in (log, quiet)]
    assert spread[1] > 1.2 * spread[0]
    assert final_error(quiet, GpsFilter(start_pose(quiet))) < 1.0


@pytest.mark.slow
def test_a_filter_that_is_beside_the_truth_believes_patient_fixes() -> None:
    log = record_course(straight_course(6), REFERENCE_NOISE, 5)
    log.fixes[:] += (30.0, -20.0)  # as from a start held for 36 m away from where it was
    localizer = GpsFilter(start_pose(log))
    shifted = Pose2(*(log.drive.poses[-1] + (30.0, -20.0, 0.0)).tolist())
    final_error(log, localizer)
    assert localizer.restarts >= 1
    assert localizer.pose.distance(shifted) < 1.5


def test_broken_readings_never_spread() -> None:
    log = record_course(straight_course(2), REFERENCE_NOISE, 6)
    rng = np.random.default_rng(0)
    for readings in (log.rates, log.accelerations, log.wheels, log.fixes):
        readings[rng.random(readings.shape) < 0.02] = rng.choice([np.nan, np.inf, -np.inf])
    localizer = GpsFilter(start_pose(log))
    assert final_error(log, localizer) < 1.5
    assert np.isfinite(localizer.covariance).all()


def test_antenna_away_from_the_middle_is_known() -> None:
    noise = RTK_NOISE._replace(antenna=(0.4, -0.3, 1.2))
    log = record_course(straight_course(2), noise, 7)
    assert final_error(log, GpsFilter(start_pose(log), noise)) < 0.05


@pytest.mark.parametrize("sigma", [0.5, 4.0])
def test_one_fix_leaves_the_position_as_unsure_as_it_is(sigma: float) -> None:
    noise = REFERENCE_NOISE._replace(antenna=(0.0, 0.0, 0.0))
    localizer = GpsFilter(Pose2(0.0, 0.0, 0.0), noise, start_position=1000.0, supposed=only(noise))
    assert localizer.fix(np.array([3.0, -2.0]), sigma)
    assert np.sqrt(np.diag(localizer.covariance)[:2]) == pytest.approx([sigma, sigma], rel=1e-3)
    assert localizer.pose[:2] == pytest.approx((3.0, -2.0), abs=1e-3)


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, -2.5])
def test_an_antenna_far_ahead_tells_the_heading_at_rest(heading: float) -> None:
    noise = RTK_NOISE._replace(antenna=(3.0, 0.0, 0.0))
    localizer = GpsFilter(Pose2(0.0, 0.0, heading), noise, start_position=0.001, supposed=only(noise))
    truth = heading + noise.start_heading
    for _ in range(50):
        assert localizer.fix(3.0 * np.array([math.cos(truth), math.sin(truth)]))
    assert localizer.pose.theta == pytest.approx(truth, abs=0.2 * noise.start_heading)


def test_no_marks_no_report() -> None:
    assert GpsFilter(Pose2(0.0, 0.0, 0.0), record=True).smoothed() == []


@pytest.mark.slow
def test_record_grows_with_the_moments_asked_for_not_with_time() -> None:
    sizes = []
    for noise in (REFERENCE_NOISE, REFERENCE_NOISE._replace(gps_period=0.2)):
        log = record_course(straight_course(5), noise, 1)
        localizer = GpsFilter(start_pose(log), noise, record=True, supposed=only(noise))
        try_course(log, localizer)
        assert len(localizer.smoothed()) == 5
        sizes.append(len(pack(to_plain(localizer.filters[0]._record, TrackRecord))))
    assert sizes[0] == pytest.approx(sizes[1], rel=0.01)
    assert sizes[0] < 5 * 5_000
