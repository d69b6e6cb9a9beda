"""When a robot counts as at rest."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.primitives.restoring.snapshot import (
    KNOWN_AGAIN,
    REST_PERIODS,
    REST_TIMEOUT_S,
    STALE_S,
    settle,
)

PERIOD = 0.05


class Wheels:
    """A robot with nothing but wheels, that rolls, or is found elsewhere, as the test says."""

    def __init__(self, rolls: tuple[int, ...] = (), pushed: int = 0) -> None:
        self.time, self.displacements, self.looks, self.stale_s = 0.0, 0, 0, 0.0
        self.localization = self
        self._rolls, self._pushed, self._travel = rolls, pushed, 0.0
        self.stalls: Callable[[int], float] = lambda _: 0.0
        self.base = SimpleNamespace(wheel_travel=lambda: (self._travel, self._travel))
        self.backend = SimpleNamespace(get=lambda _: None)

    def look_again(self) -> None:
        self.looks += 1
        self.displacements += self.looks <= self._pushed

    def settled(self) -> tuple[bool, int]:
        """Return whether the base came to rest, and after how many periods."""
        robot: Any = self
        waiting, periods = settle(robot), 0
        while True:
            try:
                next(waiting)
            except StopIteration as end:
                return end.value, periods
            self.time += PERIOD
            periods += 1
            self._travel += 0.01 * (periods in self._rolls)
            self.stale_s = self.stalls(periods)
            assert periods < 10_000, "waits without end"


def test_it_is_at_rest_after_some_periods_without_motion() -> None:
    assert Wheels().settled() == (True, REST_PERIODS)
    assert Wheels(rolls=(1, 2, 3)).settled() == (True, 3 + REST_PERIODS)


def test_motion_in_between_makes_it_wait_anew() -> None:
    assert Wheels(rolls=(REST_PERIODS - 1,)).settled() == (True, 2 * REST_PERIODS - 1)


@pytest.mark.parametrize("pushed", [1, 2])
def test_where_a_pushed_base_stands_is_known_again_only_later(pushed: int) -> None:
    """After each displacement it is localized again."""
    assert Wheels(pushed=pushed).settled() == (True, REST_PERIODS + pushed * (KNOWN_AGAIN + REST_PERIODS))


def test_what_never_stands_is_told() -> None:
    rests, periods = Wheels(rolls=tuple(range(10_000))).settled()
    assert not rests
    assert periods == pytest.approx(REST_TIMEOUT_S / PERIOD, abs=1)


def test_lidar_that_stalls_again_and_again_does_not_hold_up_the_rest() -> None:
    """It gives one new scan every 2 s while the base rolls slowly on a slope."""
    wheels = Wheels(rolls=tuple(range(0, 10_000, 3)))
    wheels.stalls = lambda periods: PERIOD * (periods % 40)
    rests, periods = wheels.settled()
    assert not rests
    assert periods <= (REST_TIMEOUT_S + STALE_S) / PERIOD + 1


def test_base_rests_after_a_lidar_has_stalled_once() -> None:
    wheels, stalled = Wheels(), round(0.9 * STALE_S / PERIOD)
    wheels.stalls = lambda periods: PERIOD * periods * (periods < stalled)
    assert wheels.settled() == (True, stalled - 1 + REST_PERIODS)
