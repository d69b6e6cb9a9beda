"""Tests of the fusion of an earlier fixation with a new one."""

from __future__ import annotations

import pytest

from handcart.backends.capabilities.base import WheelTravel
from handcart.primitives.blocks.base_turn import BaseTurn, fused
from handcart.primitives.blocks.blocks import Fixed
from handcart.robotics.geometry.pose2 import Pose2


def found_at(x: float, theta: float, sigma: tuple[float, float] = (0.0003, 0.0004)) -> Fixed:
    pose, still = Pose2(x, 0.0, theta), WheelTravel(0.0, 0.0)
    return Fixed("wall", "stacking", pose, sigma, (0.0, 0.5), (0.0, 0.0, 0.0), still, 0.0)


def test_each_weighs_by_its_variance() -> None:
    """Half the sigma is four times the weight; the turn since then is taken into account first."""
    before = found_at(0.0, -0.001, (0.0003, 0.0003))
    now = found_at(0.0005, 0.0, (0.0006, 0.001))
    both = fused(before, BaseTurn(0.0005, 0.0004), now)
    assert both.pose.x == pytest.approx(0.0001)
    assert both.pose.theta == pytest.approx(-0.0005 + 0.2 * 0.0005)
    assert both.sigma[0] == pytest.approx(0.0006 / 5**0.5)


@pytest.mark.parametrize(("x", "theta"), [(0.01, 0.0), (0.0, 0.01)])
def test_a_base_that_was_moved_meanwhile_is_where_it_is_found_now(x: float, theta: float) -> None:
    now = found_at(x, theta)
    assert fused(found_at(0.0, 0.0), BaseTurn(0.0, 0.0004), now) == now
