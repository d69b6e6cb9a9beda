"""Largest motion of a drive's position between two answers."""

from __future__ import annotations

import math

import pytest

from handcart.backends.can.drives.axis_limits import AxisLimits
from handcart.backends.can.drives.position_jumps import PositionJumps

PERIOD_S, SCALE = 0.05, 1e5
LIMITS = AxisLimits(1.0, 1.0, 2.0, -1.0, 1.0, 0.001, 1000)
NOISE = 0.1 * 0.001 * SCALE + 2.0
"""Counts that a position may move without a speed."""


def jumps(*speeds: tuple[float, float], limits: AxisLimits = LIMITS) -> PositionJumps:
    made = PositionJumps(limits, SCALE, PERIOD_S)
    for reported, commanded in speeds:
        made.note(reported, commanded)
    return made


@pytest.mark.parametrize("periods", [1, 2, 5])
@pytest.mark.parametrize("speeds", [(4000.0, 0.0), (0.0, 4000.0)])
def test_position_may_move_twice_as_far_as_its_speed(periods: int, speeds: tuple[float, float]) -> None:
    """By the reported or the commanded one, and a period more than have passed."""
    most = 2.0 * 4000.0 * PERIOD_S * (periods + 1) + NOISE
    found = jumps(speeds)
    assert found.excess(math.floor(most), periods) == 0.0
    assert found.excess(math.floor(most) + 3, periods) == pytest.approx(math.floor(most) + 3 - most)
    assert found.excess(-math.ceil(NOISE) - 3, periods) == pytest.approx(NOISE - math.ceil(NOISE) - 3)


def test_position_may_move_either_way_where_the_command_turns_round() -> None:
    found = jumps((-4000.0, 4000.0))
    assert [found.excess(moved, 1) for moved in (-800, 800)] == [0.0, 0.0]


def test_speeds_older_than_three_periods_do_not_count() -> None:
    found = jumps((4000.0, 0.0), *[(0.0, 0.0)] * 3)
    assert found.excess(800, 1) == pytest.approx(800.0 - NOISE)
    assert jumps((4000.0, 0.0), *[(0.0, 0.0)] * 2).excess(800, 1) == 0.0


def test_speeds_are_forgotten_with_the_position() -> None:
    found = jumps((4000.0, 4000.0))
    found.forget()
    found.note(0.0, 0.0)
    assert found.excess(100, 1) == pytest.approx(100.0 - NOISE)


def test_axis_that_may_be_blocked_moves_by_a_share_of_its_travel() -> None:
    free = LIMITS._replace(window=math.inf)
    found = jumps((0.0, 0.0), limits=free)
    most = math.floor(0.02 * 2.0 * SCALE + 2.0)
    assert (found.excess(most, 1), found.excess(-most, 1)) == (0.0, 0.0)
    assert found.excess(most + 5, 1) == pytest.approx(5.0)
