"""Clocks that give the time of day."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, time, timedelta
from time import monotonic

from typing_extensions import override

from handcart.backends.robot.robot import Robot

DAY_S = 86_400.0
MIN_SET_S = 60.0
"""Least jump of the machine's clock that makes expected times void, in [s]. A clock without a
battery is set by years after its robot's start.
"""


class DayClock(ABC):
    """Interface of a clock for times of day, such as 14:30.

    An instant is a point in time as [s] since the clock's origin; each kind of clock has its own origin.
    """

    @abstractmethod
    def now(self) -> float:
        """Return the present instant, in [s] since the clock's origin."""

    @abstractmethod
    def next(self, times: Sequence[time], since: float) -> float:
        """Return the first instant from `since` on that is at one of the times of day.

        Args:
            times: times of day.
            since: an instant, in [s] since the clock's origin.

        Returns:
            The instant, in [s] since the clock's origin.
        """

    def was_set(self) -> bool:
        """Return whether the clock was set to another time since the last call of this method, so that the
        results of `next` are no longer valid.
        """
        return False

    @abstractmethod
    def time_of_day(self, instant: float) -> time:
        """Return the time of day at an instant, which is in [s] since the clock's origin."""


class RehearsedDay(DayClock):
    """Clock of a rehearsal (a run on a simulated robot), which shows a chosen time of day plus the robot's
    time.

    Instants are in [s] since midnight of the first day.
    """

    def __init__(self, robot: Robot, begins_at: time) -> None:
        """Let the robot's time 0 be a time of day."""
        self._robot, self._begins = robot, _seconds(begins_at)

    @override
    def now(self) -> float:
        return self._begins + self._robot.time

    @override
    def next(self, times: Sequence[time], since: float) -> float:
        return since + min((_seconds(item) - since) % DAY_S for item in times)

    @override
    def time_of_day(self, instant: float) -> time:
        return (datetime.min + timedelta(seconds=round(instant % DAY_S))).time()


def since_1970() -> float:
    """Return the time of the computer's clock, in [s] since 1970 (UTC)."""
    return datetime.now(UTC).timestamp()


class LocalDay(DayClock):
    """The computer's clock, with times of day in its time zone; instants are in [s] since 1970 (UTC)."""

    def __init__(
        self, clock: Callable[[], float] = since_1970, steady: Callable[[], float] = monotonic
    ) -> None:
        """Use a clock in [s] since 1970; a steady clock, which nobody sets, shows jumps of the first."""
        self._clock, self._steady = clock, steady
        self._ahead = clock() - steady()

    @override
    def now(self) -> float:
        return self._clock()

    @override
    def was_set(self) -> bool:
        ahead = self._clock() - self._steady()
        if abs(ahead - self._ahead) < MIN_SET_S:
            return False
        self._ahead = ahead
        return True

    @override
    def next(self, times: Sequence[time], since: float) -> float:
        today = datetime.fromtimestamp(since).date()
        days = (today + timedelta(days=number) for number in range(3))
        instants = (datetime.combine(day, item).timestamp() for day in days for item in times)
        return min(instant for instant in instants if instant >= since)

    @override
    def time_of_day(self, instant: float) -> time:
        return datetime.fromtimestamp(instant).time()


def after(instant: float) -> float:
    """Return the least floating-point number above an instant, in [s]."""
    return math.nextafter(instant, math.inf)


def _seconds(item: time) -> float:
    return item.hour * 3600.0 + item.minute * 60.0 + item.second
