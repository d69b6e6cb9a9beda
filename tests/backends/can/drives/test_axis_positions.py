"""Reported positions of a drive: which ones an axis accepts and refuses, and its messages."""

from __future__ import annotations

from typing import Any

import pytest

from handcart.backends.capabilities.base import Base

from ..conftest import LEFT, Make


@pytest.fixture
def axis(make: Make) -> Any:
    """The left wheel's, at rest; it is given reports by hand."""
    backend = make(room=False)
    backend.get(Base).drive(0.0, 0.0)
    backend.step()
    return backend.axes["left wheel"]


def way_of(axis: Any, periods: float) -> int:
    """Counts of so many periods at the speed limit."""
    counts: float = periods * axis.limits.speed * axis.period * abs(axis.units.scale)
    return round(counts)


def report(axis: Any, moved: int, reported: int) -> None:
    """One answer: so many counts further, at so many counts a second."""
    axis.ask()
    axis._reported[0x606C] = reported
    axis._take_position(axis._counts + moved)


def test_jump_beyond_four_periods_is_rejected_despite_its_speed(axis: Any) -> None:
    fast = 20 * way_of(axis, 1.0 / axis.period)
    for periods in (-10.0, 10.0, 4.1, -4.1):
        travel, counts = axis.travel, axis._counts
        report(axis, way_of(axis, periods), fast if periods > 0.0 else -fast)
        assert (axis.odd, axis.travel, axis._counts) == (1, travel, counts)
        assert axis.jump.startswith(f"by {way_of(axis, periods)} counts (")
        report(axis, 0, 0)
        assert axis.odd == 0
    report(axis, way_of(axis, 3.9), fast)
    assert axis.odd == 0
    assert axis._counts == counts + way_of(axis, 3.9)


def test_each_refused_position_lets_the_next_be_one_period_further(axis: Any) -> None:
    fast = 20 * way_of(axis, 1.0 / axis.period)
    for odd, periods in enumerate((4.1, 6.1, 8.1), 1):
        report(axis, way_of(axis, periods), fast)
        assert axis.odd == odd
    assert axis.jump.startswith(f"by {way_of(axis, 4.1)} counts (")  # the first is reported
    report(axis, way_of(axis, 9.9), fast)
    assert axis.odd == 0


def test_travel_is_what_was_taken_over_and_differs_from_what_was_told(axis: Any) -> None:
    travel, contradiction = axis.travel, axis.contradiction
    reported = way_of(axis, 1.0 / axis.period)
    for _ in range(3):
        report(axis, way_of(axis, 0.5), reported)
    step = way_of(axis, 0.5) / axis.units.scale
    assert axis.travel - travel == pytest.approx(3 * step)
    expected = 3 * (step - reported * axis.period / axis.units.scale)
    assert axis.contradiction - contradiction == pytest.approx(expected)


def test_an_axis_is_silent_by_the_syncs_it_has_not_answered(axis: Any) -> None:
    assert (axis.unanswered, axis.answered, axis.missing) == (0, True, [])
    axis.ask()
    axis.ask()
    assert (axis.unanswered, axis.answered) == (2, False)
    assert [item.number for item in axis.missing] == [1, 2]
    assert axis.ever_answered


def test_units_of_what_an_axis_reports(axis: Any) -> None:
    axis._reported |= {0x606C: way_of(axis, 0.5 / axis.period), 0x6077: -250, 0x6061: 3}
    sign = 1.0 if axis.units.scale > 0.0 else -1.0
    assert axis.velocity == pytest.approx(0.5 * sign * axis.limits.speed, rel=1e-3)
    assert axis.torque == -0.25 * sign
    assert axis.mode_display == 3
    assert not axis.stands
    axis._reported[0x606C] = 0
    assert axis.stands
    assert axis.spec.node == LEFT
