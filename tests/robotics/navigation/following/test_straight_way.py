"""A base on a straight path, at a given pace."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.following.straight_way import StraightWay

DT = 0.05
LIMITS = DriveLimits(0.4, 0.8, 0.3, 1.5)


@pytest.mark.slow
@given(
    st.floats(-0.05, 0.05),
    st.floats(-0.05, 0.05),
    st.floats(-0.1, 0.1),
    st.sampled_from((0.1, -0.1)),
    st.floats(0.97, 1.03),
)
def test_a_base_comes_back_to_its_way_and_keeps_pace(
    ahead: float, beside: float, turned: float, speed: float, slips: float
) -> None:
    """In both directions, with wheels that roll further than they report."""
    start = Pose2(1.0, -2.0, 0.7)
    way, pose = StraightWay(start, LIMITS), start.compose(Pose2(ahead, beside, turned))
    for period in range(900):
        v, turn = way.command(pose, speed * period * DT, speed, DT)
        assert abs(v) <= LIMITS.speed
        assert abs(turn) <= LIMITS.turn_rate
        half = Pose2(0.0, 0.0, 0.5 * turn * DT)
        pose = pose.compose(half).compose(Pose2(slips * v * DT, 0.0, 0.0)).compose(half)
    off = pose.relative_to(start)
    assert abs(off.y) < 0.002
    assert abs(off.theta) < math.radians(0.2)
    assert abs(off.x - speed * 900 * DT) < 0.01
