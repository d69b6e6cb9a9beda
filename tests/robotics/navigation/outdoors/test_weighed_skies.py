"""Hypotheses and claims of the multiple models, in exact figures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_localizer import inconsistency_of
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.noise_hypotheses import noise_hypotheses

GIVEN = REFERENCE_NOISE._replace(gps_white=2.0, gps_drift=0.5, antenna=(0.0, 0.0, 0.0))
DRIFTS = [0.5, math.hypot(0.5, 0.5), math.hypot(0.5, 1.5), math.hypot(0.5, 6.0)]
SHARES = np.outer([0.55, 0.25, 0.15, 0.05], [0.6, 0.3, 0.1]).ravel()


def test_worlds_are_supposed_with_these_figures() -> None:
    found = noise_hypotheses(GIVEN)
    assert [hypothesis.share for hypothesis in found] == pytest.approx(SHARES.tolist())
    assert [hypothesis.worse for hypothesis in found] == [3, 4, 5, 6, 7, 8, 9, 10, 11, 9, 10, 11]
    assert [hypothesis.noise.gps_drift for hypothesis in found] == pytest.approx(
        np.repeat(DRIFTS, 3).tolist()
    )
    assert [hypothesis.noise.gps_drift_time for hypothesis in found] == [300.0] * 3 + [600.0] * 9
    assert [hypothesis.noise.jump_every for hypothesis in found] == [math.inf] * 9 + [1000.0] * 3
    assert [hypothesis.noise.jump for hypothesis in found[9:]] == pytest.approx([DRIFTS[3]] * 3)
    assert {hypothesis.noise.gps_delay for hypothesis in found} == {0.3}
    assert [hypothesis.noise.gps_delay for hypothesis in noise_hypotheses(GIVEN._replace(gps_delay=0.4))] == [
        0.4
    ] * 12
    for as_told, slipping, turned in zip(found[::3], found[1::3], found[2::3], strict=True):
        assert as_told.noise.scale == turned.noise.scale == GIVEN.scale
        assert slipping.noise.scale == pytest.approx(5.0 * GIVEN.scale)
        assert slipping.noise.slip == pytest.approx(5.0 * GIVEN.slip)
        assert slipping.noise.turn_slip == pytest.approx(5.0 * GIVEN.turn_slip)
        assert slipping.noise.side_slip == pytest.approx(3.0 * GIVEN.side_slip)
        assert as_told.noise.start_heading == slipping.noise.start_heading == math.radians(1.0)
        assert turned.noise.start_heading == pytest.approx(math.radians(6.0))
    assert noise_hypotheses(GIVEN._replace(start_heading=0.3))[2].noise.start_heading == 0.3


def test_claims_suppose_a_worse_sky_than_was_seen() -> None:
    filtering = GpsFilter(Pose2(0.0, 0.0, 0.0), GIVEN)
    moved = SHARES * [0.015, *[0.3] * 11]
    cautious = SHARES - moved
    for k, share in enumerate(moved):
        cautious[k + 3 if k < 9 else k] += share
    drifts = np.repeat(np.square(DRIFTS), 3)
    now = filtering.mark()
    assert now.covariance[states.GPS_X, states.GPS_X] == pytest.approx(cautious @ drifts)
    headings = np.array([1.0, 1.0, 6.0] * 4)
    assert filtering.covariance[2, 2] == pytest.approx(cautious @ np.radians(headings) ** 2)
    assert filtering.covariance[:2, :2] == pytest.approx(0.05**2 * np.eye(2))


def test_a_fix_weighs_worlds_that_may_have_become_worse() -> None:
    filtering = GpsFilter(Pose2(0.0, 0.0, 0.0), GIVEN)
    filtering.fix(np.array([3.0, -2.0]), 1.0)
    variances = 0.05**2 + 1.0 + np.repeat(np.square(DRIFTS), 3)
    densities = np.exp(-0.5 * 13.0 / variances) / variances
    leaps = -math.expm1(-0.1 / 1000.0)  # the fourth sky: the same normal density, leapt or not
    assert leaps > 0.0
    worlds = noise_hypotheses(GIVEN)
    becomes = SHARES + 1e-4 * np.array(
        [SHARES[b] * sum(SHARES[a] for a in range(12) if worlds[a].may_become(worlds[b])) for b in range(12)]
    )
    expected = becomes * densities
    assert filtering.weights == pytest.approx(expected / expected.sum(), rel=1e-3)


def test_headings_across_half_a_turn_mix_near_it() -> None:
    for start in (math.pi - 0.001, -math.pi + 0.001):
        filtering = GpsFilter(Pose2(0.0, 0.0, start), GIVEN)
        assert math.cos(filtering.pose.theta - start) == pytest.approx(1.0)
        assert filtering.covariance[2, 2] < math.radians(6.0) ** 2


def test_where_no_heading_is_given_the_place_is_unsure() -> None:
    filtering = GpsFilter(Pose2(0.0, 0.0, 0.0), GIVEN._replace(start_heading=math.inf), 0.2)
    assert not filtering.heading_known
    assert filtering.covariance == pytest.approx(np.diag([0.04, 0.04, math.pi**2 / 3.0]))
    assert GpsFilter(Pose2(0.0, 0.0, 0.0), GIVEN._replace(start_heading=1.0)).heading_known
    assert not GpsFilter(Pose2(0.0, 0.0, 0.0), GIVEN._replace(start_heading=1.01)).heading_known


def test_readings_are_inconsistent_beyond_exact_limits() -> None:
    assert inconsistency_of([(0.0, 50.0)] * 9) is None
    found = inconsistency_of([(0.0, 50.0)] * 10)
    assert found is not None
    assert (found.value, found.limit) == pytest.approx((25.0, 1.0 + 4.0 * math.sqrt(0.1)))
    assert "mean square" in found.what
    limit = 2.0 * (1.0 + 4.0 * math.sqrt(0.1))
    assert inconsistency_of([(0.0, limit - 1e-6)] * 10) is None
    assert inconsistency_of([(0.0, limit + 1e-6)] * 10) is not None
    assert inconsistency_of([(0.0, 2.0)] * 10, axes=1) is None
    one = inconsistency_of([(0.0, 3.0)] * 10, axes=1)
    assert one is not None
    assert (one.value, one.limit) == pytest.approx((3.0, 1.0 + 4.0 * math.sqrt(0.2)))
    assert inconsistency_of([(0.0, 2.0), (0.0, None)] * 5) is None
    refused = inconsistency_of([(0.0, 2.0)] * 5 + [(0.0, None)] * 6)
    assert refused is not None
    assert (refused.value, refused.limit) == pytest.approx((6.0 / 11.0, 0.5))
    assert "believed" in refused.what
