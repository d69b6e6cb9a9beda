"""When a base that is driven counts as one that something stops."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.blocked_motion import Blocked, BlockedMotion

PERIOD = 0.05
NOISE = 0.004  # [m] of an estimated pose


def drive(
    speeds: list[float], share: float, rolls: float = 1.0, seed: int = 0
) -> tuple[Blocked | None, float]:
    """Drive along a heading of 0.7 rad; return what was found, and when in [s].

    Args:
        speeds: commanded in each period, in [m/s].
        share: of the commanded distance by which the base moves.
        rolls: likewise by which its wheels roll.
        seed: of the noise of the pose.
    """
    random, motion, way = np.random.default_rng(seed), BlockedMotion(PERIOD), 0.0
    before = Pose2(0.0, 0.0, 0.7)
    for number, speed in enumerate(speeds, start=1):
        way += share * speed * PERIOD
        off_x, off_y = (NOISE * random.standard_normal(2)).tolist()
        now = Pose2(way * math.cos(0.7) + off_x, way * math.sin(0.7) + off_y, 0.7)
        found = motion.update(speed, rolls * speed * PERIOD, before, now)
        if found is not None:
            return found, number * PERIOD
        before = now
    return None, math.inf


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.6, -0.05, -0.6])
@pytest.mark.parametrize("rolls", [0.0, 1.0])
def test_a_base_that_is_stopped_is_found_within_a_second(speed: float, rolls: float) -> None:
    found, after = drive([speed] * 40, share=0.0, rolls=rolls)
    assert found is not None
    assert after <= 1.0
    assert found.forwards is (speed > 0.0)
    assert found.slips is (rolls == 1.0)


@pytest.mark.parametrize("speed", [0.01, 0.05, 0.3, -0.3])
def test_a_base_that_gets_on_is_never_taken_for_stopped(speed: float) -> None:
    """Also with wheels that slip by 40 %."""
    for seed in range(50):
        assert drive([speed] * 60, share=0.6, seed=seed)[0] is None


def test_a_base_that_starts_to_move_late_is_not_taken_for_stopped() -> None:
    motion, way, before = BlockedMotion(PERIOD), 0.0, Pose2(0.0, 0.0, 0.0)
    speeds = [min(0.6, 0.5 * PERIOD * number) for number in range(1, 30)]
    for number, speed in enumerate(speeds):
        moves = speeds[number - 3] if number >= 3 else 0.0  # three periods late
        way += moves * PERIOD
        now = Pose2(way, 0.0, 0.0)
        assert motion.update(speed, moves * PERIOD, before, now) is None
        before = now


def test_a_command_that_turns_round_starts_a_new_window() -> None:
    found, _ = drive([0.1, -0.1] * 30, share=0.0)
    assert found is None
    found, _ = drive(([0.2] * 6 + [0.0]) * 10, share=0.0)
    assert found is None


def test_a_base_that_rebounds_is_found_where_it_was_stopped() -> None:
    """It hits something at 0.5 m, is thrown back by 0.2 m and driven on."""
    motion, before = BlockedMotion(PERIOD), Pose2(0.0, 0.0, 0.0)
    way = [*np.arange(0.05, 0.51, 0.03), 0.42, 0.34, 0.3, 0.3, 0.31, 0.33, 0.36, 0.39, 0.42]
    for number, x in enumerate(way):
        now = Pose2(float(x), 0.0, 0.0)
        found = motion.update(0.6, 0.03, before, now)
        if found is not None:
            assert found.pose.x == pytest.approx(max(way[:16]))
            assert found.moved <= 0.0
            assert (number - 15) * PERIOD <= 0.45
            return
        before = now
    raise AssertionError("the base was thrown back, and nothing noticed it")
