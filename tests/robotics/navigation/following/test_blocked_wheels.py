"""When a base counts as held at a wheel, or on the spot."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.blocked_wheels import BlockedWheel, BlockedWheels
from handcart.robotics.navigation.locating.moved_scan import rolled_motion

PERIOD_S, TREAD_M = 0.05, 0.4


def drive(
    command: tuple[float, float], shares: tuple[float, float], seed: int = 0
) -> tuple[BlockedWheel | None, float]:
    """Drive for 2 s; return what was found, and after how many seconds."""
    random, wheels = np.random.default_rng(seed), BlockedWheels(PERIOD_S, TREAD_M)
    pose = before = Pose2(1.0, 2.0, 0.7)
    left, right = (PERIOD_S * (command[0] + sign * TREAD_M / 2 * command[1]) for sign in (-1.0, 1.0))
    for number in range(1, 41):
        pose = pose.compose(rolled_motion(shares[0] * left, shares[1] * right, 0.0, TREAD_M))
        x, y, turn = random.normal(0.0, (0.004, 0.004, 0.002)).tolist()
        now = Pose2(pose.x + x, pose.y + y, pose.theta + turn)
        found = wheels.update(command, (left, right), before, now)
        if found is not None:
            return found, number * PERIOD_S
        before = now
    return None, np.inf


@pytest.mark.parametrize("command", [(0.0, 1.0), (0.0, -0.6), (0.3, 0.5), (-0.3, 0.0)])
@pytest.mark.parametrize(
    ("shares", "side"), [((0.0, 0.0), "both"), ((0.0, 1.0), "left"), ((1.0, 0.0), "right")]
)
def test_a_held_wheel_is_found_within_a_second(
    command: tuple[float, float], shares: tuple[float, float], side: str
) -> None:
    found, seconds = drive(command, shares)
    assert found is not None
    assert seconds <= 1.0
    assert found.evidence.slips
    assert found.side in (side, "left", "right") if side == "both" else found.side == side


@pytest.mark.parametrize("command", [(0.0, 1.0), (0.0, 0.05), (0.3, 0.5), (0.3, 1.5), (0.02, 0.0)])
def test_wheels_that_get_on_are_never_held(command: tuple[float, float]) -> None:
    for seed in range(10):
        assert drive(command, (0.6, 0.6), seed)[0] is None
