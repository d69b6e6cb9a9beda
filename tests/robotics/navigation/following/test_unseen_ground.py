"""Ground ahead of a disc that a lidar sees, and ground that it does not see."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.unseen_ground import HIDDEN_M, is_driven, unseen_edge

RADIUS = 0.34
ROUND = np.radians(np.arange(-180.0, 180.0))
HALF = np.radians(np.arange(-90.0, 91.0))
MIDDLE, FRONT = Pose2(0.0, 0.0, 0.0), Pose2(0.3, 0.0, 0.0)


def no_blind(angles: np.ndarray) -> np.ndarray:
    return np.zeros(len(angles), np.bool_)


@given(st.floats(-3.0, 3.0), st.floats(0.001, 1.0), st.sampled_from([MIDDLE, FRONT]))
def test_half_a_turn_sees_ahead_and_nothing_behind(curvature: float, way: float, mount: Pose2) -> None:
    assert unseen_edge(ROUND, no_blind(ROUND), mount, RADIUS, curvature, way) is None
    assert unseen_edge(ROUND, no_blind(ROUND), mount, RADIUS, curvature, -way) is None
    behind = unseen_edge(HALF, no_blind(HALF), mount, RADIUS, 0.0, -way)
    assert unseen_edge(HALF, no_blind(HALF), mount, RADIUS, 0.0, way) is None
    assert behind is not None
    assert behind[0] < -RADIUS * math.cos(math.radians(60.0))


@given(st.integers(-30, 30), st.integers(1, 60), st.floats(-math.pi, math.pi))
def test_a_blind_sector_ahead_holds_from_a_width_on(middle: int, width: int, turned: float) -> None:
    """Whichever way the lidar is mounted: a sector as wide as `HIDDEN_M` on the leading edge, or wider."""
    direction = np.radians(middle)
    blind = np.abs((ROUND + turned - direction + math.pi) % (2 * math.pi) - math.pi) < math.radians(width / 2)
    found = unseen_edge(ROUND, blind, Pose2(0.0, 0.0, turned), RADIUS, 0.0, 0.3)
    far = 0.3 + RADIUS
    if math.radians(width - 1.0) * RADIUS > 1.3 * HIDDEN_M * 1.5:
        assert found is not None
    if math.radians(width + 1.0) * far < 0.8 * HIDDEN_M:
        assert found is None


@pytest.mark.parametrize("behind", [2.6, 2.9, 3.3, 3.6])
def test_a_blind_sector_across_the_seam_of_a_full_turn_counts(behind: float) -> None:
    blind = np.abs((ROUND - math.pi + math.pi) % (2 * math.pi) - math.pi) < math.radians(20.0)
    found = unseen_edge(ROUND, blind, MIDDLE, RADIUS, 0.0, -0.3)
    assert found is not None
    assert abs(found[1]) < 0.05
    turned = Pose2(0.0, 0.0, behind)
    assert (
        unseen_edge(ROUND, np.roll(blind, -round(math.degrees(behind))), turned, RADIUS, 0.0, -0.3)
        is not None
    )


def test_ground_counts_as_driven_within_a_hand_of_the_way() -> None:
    driven = np.column_stack([np.linspace(0.0, 2.0, 101), np.zeros(101)])
    assert is_driven(driven, Pose2(2.0, 0.05, 0.0), 0.0, -0.5)
    assert not is_driven(driven, Pose2(2.0, 0.15, 0.0), 0.0, -0.5)
    assert not is_driven(driven, Pose2(0.3, 0.0, 0.0), 0.0, -0.5)
    assert not is_driven(driven, Pose2(2.0, 0.0, 0.0), 2.0, -0.5)
    assert not is_driven(np.empty((0, 2)), Pose2(0.0, 0.0, 0.0), 0.0, 0.1)
