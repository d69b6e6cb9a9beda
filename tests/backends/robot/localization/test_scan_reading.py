"""Raw readings of any driver become scans whose beams have a validity."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.backends.capabilities.scan import Scan, Validity
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.robot.guarded_base import steady_points
from handcart.backends.robot.localization.scan_reading import WITHIN_FOOTPRINT_M, read_scan
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

FOOTPRINT, LEAST, REACH = 0.34, 0.15, 8.0
MOUNT = Pose2(0.1, -0.05, 0.3)
READINGS = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(-1.0, 10.0),
    st.sampled_from([0.0, -0.0, LEAST, REACH, math.nan, math.inf, -math.inf]),
)
HABITS = st.lists(st.sampled_from(["zero", "below_min", "nan"]), unique=True, max_size=3).map(tuple)
SPECS = st.builds(
    RangeSpec,
    beams=st.just(36),
    reach_m=st.just(REACH),
    range_min_m=st.just(LEAST),
    sigma_mm=st.just(10.0),
    start_deg=st.sampled_from([-180.0, -135.0, 0.0]),
    end_deg=st.sampled_from([90.0, 135.0, 180.0]),
    masked_deg=st.sampled_from([(), ((30.0, 60.0),), ((170.0, -170.0), (0.0, 10.0))]),
    no_return=HABITS,
)


def spec(**keys: object) -> RangeSpec:
    return RangeSpec.model_validate(
        {"beams": 4, "reach_m": REACH, "range_min_m": LEAST, "sigma_mm": 10.0, **keys}
    )


def validities(readings: list[float], **keys: object) -> list[Validity]:
    limits = spec(beams=len(readings), **keys)
    raw = Scan(limits.angles(), np.array(readings), Pose2(0.0, 0.0, 0.0))
    return [Validity(value) for value in read_scan(raw, limits, Footprint(FOOTPRINT)).validity]


@pytest.mark.slow
@given(SPECS, st.lists(READINGS, min_size=36, max_size=36))
def test_any_reading_becomes_a_range_or_none(limits: RangeSpec, readings: list[float]) -> None:
    raw = Scan(limits.angles(), np.array(readings), MOUNT)
    before = raw.ranges.copy()
    read = read_scan(raw, limits, Footprint(FOOTPRINT))
    returns = read.validity == Validity.RETURN
    np.testing.assert_array_equal(raw.ranges, before)
    np.testing.assert_array_equal(np.isfinite(read.ranges), returns)
    np.testing.assert_array_equal(read.ranges[returns], raw.ranges[returns])
    assert (read.ranges[~returns] == np.inf).all()
    assert ((read.ranges[returns] >= LEAST) & (read.ranges[returns] <= REACH)).all()
    assert len(read.points()) == returns.sum()
    if returns.any():
        assert np.hypot(*read.points().T).min() >= FOOTPRINT - WITHIN_FOOTPRINT_M - 1e-9
    assert (read.validity[limits.masked(raw.angles)] == Validity.INVALID).all()
    assert not (read.blind() & (raw.ranges == np.inf) & ~limits.masked(raw.angles)).any()


@pytest.mark.slow
@given(SPECS, st.lists(READINGS, min_size=36, max_size=36))
def test_a_read_scan_written_by_rep_117_reads_the_same(limits: RangeSpec, readings: list[float]) -> None:
    read = read_scan(Scan(limits.angles(), np.array(readings), MOUNT), limits, Footprint(FOOTPRINT))
    plain = limits.model_copy(update={"no_return": (), "masked_deg": ()})
    again = read_scan(read._replace(ranges=read.rep117()), plain, Footprint(FOOTPRINT))
    np.testing.assert_array_equal(again.validity, read.validity)
    np.testing.assert_array_equal(again.ranges, read.ranges)


@given(SPECS, st.lists(READINGS, min_size=36, max_size=36), st.integers(0, 35), READINGS)
def test_one_wrong_beam_never_adds_a_lone_obstacle(
    limits: RangeSpec, readings: list[float], beam: int, wrong: float
) -> None:
    """All beams at 3 m but one, whatever it delivers: what the guard is given is at 3 m."""
    ranges: FloatArray = np.full(36, 3.0)
    ranges[beam] = wrong
    points = steady_points(
        read_scan(Scan(limits.angles(), ranges, Pose2(0.0, 0.0, 0.0)), limits, Footprint(FOOTPRINT))
    )
    assert (np.hypot(*points.T) >= 3.0 - 1e-9).all()


def test_readings_mean_what_rep_117_says() -> None:
    found = validities([math.inf, -math.inf, math.nan, 1.0, 0.0, -0.5, 0.1, 9.0])
    close, gone = Validity.TOO_CLOSE, Validity.NO_RETURN
    assert found == [gone, close, Validity.INVALID, Validity.RETURN, gone, gone, close, gone]


def test_drivers_have_other_habits_by_their_key() -> None:
    gone = Validity.NO_RETURN
    assert validities([0.0, 0.1, math.nan], no_return=[]) == [
        Validity.INVALID,
        Validity.TOO_CLOSE,
        Validity.INVALID,
    ]
    assert validities([0.0, 0.1, math.nan], no_return=["zero", "below_min", "nan"]) == [gone] * 3


def test_returns_of_the_own_body_are_too_close() -> None:
    """From a lidar 0.2 m ahead of the middle: the footprint ends 0.54 m behind it, 0.14 m ahead."""
    limits = spec(range_min_m=0.0)
    raw = Scan(limits.angles(), np.full(4, 0.4), Pose2(0.2, 0.0, 0.0))
    read = read_scan(raw, limits, Footprint(FOOTPRINT))
    assert list(read.validity) == [Validity.TOO_CLOSE, Validity.RETURN, Validity.RETURN, Validity.RETURN]


@pytest.mark.parametrize(("goes_round", "kept"), [(True, 2), (False, 0)])
def test_ends_of_a_scan_are_neighbours_on_a_full_turn_only(goes_round: bool, kept: int) -> None:
    limits = spec(beams=36, **({} if goes_round else {"start_deg": -90.0, "end_deg": 90.0}))
    ranges = np.full(36, np.inf)
    ranges[[0, -1]] = 1.0
    scan = read_scan(Scan(limits.angles(), ranges, Pose2(0.0, 0.0, 0.0)), limits, Footprint(FOOTPRINT))
    assert len(steady_points(scan)) == kept


def test_blind_beams_between_two_returns_do_not_hide_them() -> None:
    limits = spec(beams=36)
    ranges = np.full(36, 3.0)
    ranges[10:13] = 0.6, -np.inf, 0.6
    scan = read_scan(Scan(limits.angles(), ranges, Pose2(0.0, 0.0, 0.0)), limits, Footprint(FOOTPRINT))
    assert np.isclose(np.hypot(*steady_points(scan).T), 0.6).sum() == 2
