"""Steps of a hand that pulls, by how stiff its arm is found to be."""

from __future__ import annotations

import pytest

from handcart.primitives.doors.pulling import BLOCKED_PERIODS, MAX_FORCE_N, MAX_PULL_N, is_blocked
from handcart.primitives.doors.stiffness import Stiffness

FIRST_STEP_M = 0.000075  # of a hand that begins to move


def most_felt(stiffness: float, periods: int = BLOCKED_PERIODS) -> list[float]:
    """Forces in [N] of a hand on a handle that doesn't move, period by period."""
    found, felt, step = Stiffness(MAX_PULL_N, MAX_FORCE_N), 0.0, FIRST_STEP_M
    found.add(0.0, 0.0)
    forces = []
    for _ in range(periods):
        felt += stiffness * step
        forces.append(felt)
        found.add(step, felt)
        step = min(found.step(felt), found.sudden_step(), max(0.0, step) + FIRST_STEP_M)
    return forces


@pytest.mark.parametrize("stiffness", [2e3, 2e4, 9e4])
def test_pull_on_a_locked_door_ends_at_the_limit(stiffness: float) -> None:
    forces = most_felt(stiffness)
    assert max(forces) < 21.0
    assert forces[-1] == pytest.approx(18.0, abs=1.5)


@pytest.mark.parametrize("stiffness", [1e4, 9e4])
def test_handle_that_stops_suddenly_is_felt_below_the_limit(stiffness: float) -> None:
    found = Stiffness(MAX_PULL_N, MAX_FORCE_N)
    found.add(0.0, 0.0)
    found.add(0.0001, 0.0001 * stiffness)
    assert 10.0 + stiffness * found.sudden_step() < MAX_FORCE_N


def test_handle_that_creeps_is_blocked_and_one_that_goes_is_not() -> None:
    way = [0.01 + 0.00002 * number for number in range(BLOCKED_PERIODS + 1)]
    assert is_blocked(way) and not is_blocked(way[1:])
    assert not is_blocked([4.0 * item for item in way])
