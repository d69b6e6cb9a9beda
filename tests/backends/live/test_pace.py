"""The clock of hardware: how late it is, and when that has to stop the robot."""

from __future__ import annotations

import pytest

from handcart.backends.live.pace import Pace


class Clock:
    """A clock that ends each sleep `late` seconds late."""

    def __init__(self) -> None:
        self.now, self.late, self.slept = 100.0, 0.0, 0.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds + self.late

    def asleep(self) -> float:
        return self.slept


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def pace(clock: Clock) -> Pace:
    return Pace(0.01, clock, clock.sleep, clock.asleep)


def test_periods_dont_add_up_their_lateness(clock: Clock, pace: Pace) -> None:
    clock.late = 0.002
    for _ in range(100):
        pace.wait()
    assert clock.now == pytest.approx(100.0 + 1.0 + 0.002)
    assert pace.trouble == ""
    figures = pace.figures()
    assert (figures["periods"], figures["missed"]) == (100, 0)
    assert figures["late_p50_ms"] == figures["late_max_ms"] == pytest.approx(2.0, abs=1e-3)


def test_two_missed_are_borne(clock: Clock, pace: Pace) -> None:
    for _ in range(20):
        for work in (0.012, 0.012, 0.001):
            clock.now += work
            pace.wait()
    assert pace.trouble == ""
    assert pace.late == 40


def test_k7_three_missed_in_a_row_stop(clock: Clock, pace: Pace) -> None:
    """K7: three in a row."""
    for _ in range(3):
        clock.now += 0.012
        pace.wait()
    assert pace.trouble == "3 periods of 10 ms in a row were missed; allowed: 2"


def test_k7_one_gap_stops(clock: Clock, pace: Pace) -> None:
    """K7: one gap of more than 50 ms, by computing or sleeping; reported for good."""
    clock.late = 0.063
    pace.wait()
    clock.late = 0.0
    for _ in range(9):
        pace.wait()
    assert pace.trouble == "a period ended 63 ms late; allowed: 50 ms"
    other = Pace(0.01, clock, clock.sleep, clock.asleep)
    clock.now += 0.07
    other.wait()
    assert other.trouble == "a period ended 60 ms late; allowed: 50 ms"


def test_k9_suspended(clock: Clock, pace: Pace) -> None:
    """K9: the machine was suspended; the clock that counts periods did not run meanwhile."""
    pace.wait()
    clock.slept = 12.0
    pace.wait()
    assert pace.trouble == "the machine was suspended for 12 s"


def test_setting_up_is_no_period(clock: Clock, pace: Pace) -> None:
    clock.now += 3.0
    pace.begin()
    pace.wait()
    assert pace.trouble == ""
    assert pace.figures()["periods"] == 1


def test_the_real_clock() -> None:
    pace = Pace(0.005)
    for _ in range(5):
        pace.wait()
    assert pace.figures()["periods"] == 5
    assert "suspended" not in pace.trouble
