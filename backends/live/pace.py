"""The clock of hardware."""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

MAX_MISSED_PERIODS = 3
"""Number of missed periods in a row that is a fault."""
MAX_PERIOD_EXCESS_S = 0.05
"""Largest excess of a period over its duration, in [s]."""
SUSPENDED_S = 0.01
"""Largest difference of two readings of `suspended` without a suspension, in [s], due to its two clocks."""


def suspended() -> float:
    """Return the time for which the machine has been suspended (asleep) since it was started, in [s]."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()


class Pace:
    """Timer of control periods by the wall clock.

    If a period ends late, the next one begins at that time: later periods are not shortened to catch up.
    """

    def __init__(
        self,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
        asleep: Callable[[], float] = suspended,
        max_excess: float = MAX_PERIOD_EXCESS_S,
        max_missed: int | None = None,
    ) -> None:
        """Start the first period now.

        Args:
            period: duration of a period, in [s].
            clock: gives the time in [s].
            sleep: waits so many seconds.
            asleep: returns the time in [s] for which the machine has been suspended since its start.
            max_excess: largest excess of a period over its duration, in [s].
            max_missed: missed periods in a row that are a fault; None: `MAX_MISSED_PERIODS`.
        """
        self._period, self._clock, self._sleep, self._asleep = period, clock, sleep, asleep
        self._slept, self._max_excess = asleep(), max_excess
        self._max_missed = MAX_MISSED_PERIODS if max_missed is None else max_missed
        self._end = clock() + period
        self._lateness = array("f")
        self._in_a_row, self._longest = 0, 0.0
        self.late = 0
        """Number of periods that were over before the wait."""
        self.trouble = ""
        """Reason why the robot has to be stopped; "" if there is none. A reason stays once it is set."""

    def wait(self) -> None:
        """Wait for the end of the current period, and start the next one."""
        now = self._clock()
        if now <= self._end:
            self._sleep(self._end - now)
            self._note(max(0.0, self._clock() - self._end), missed=False)
            self._end += self._period
        else:
            self._note(now - self._end, missed=True)
            self._end = now + self._period

    def begin(self) -> None:
        """Start the first period now, so that earlier work, such as drive set-up, does not make it late."""
        self._end = self._clock() + self._period
        self._in_a_row = 0

    def figures(self) -> Mapping[str, Any]:
        """Return the number of periods, the number of missed ones, and percentiles of how late periods ended,
        in [ms].
        """
        if not self._lateness:
            return {"periods": 0, "missed": 0}
        p50, p99 = (1e3 * float(item) for item in np.percentile(self._lateness, (50, 99)))
        return {
            "periods": len(self._lateness),
            "missed": self.late,
            "late_p50_ms": round(p50, 3),
            "late_p99_ms": round(p99, 3),
            "late_max_ms": round(1e3 * self._longest, 3),
        }

    def _note(self, lateness: float, missed: bool) -> None:
        self._lateness.append(lateness)
        self._longest = max(self._longest, lateness)
        self.late += missed
        self._in_a_row = self._in_a_row + 1 if missed else 0
        self.trouble = self.trouble or self._found(lateness)

    def _found(self, lateness: float) -> str:
        slept = self._asleep() - self._slept
        if slept > SUSPENDED_S:
            return f"the machine was suspended for {slept:.3g} s"
        if lateness > self._max_excess:
            return f"a period ended {1e3 * lateness:.0f} ms late; allowed: {1e3 * self._max_excess:.0f} ms"
        if self._in_a_row >= self._max_missed:
            finding = f"{self._max_missed} periods of {1e3 * self._period:g} ms in a row were missed"
            return f"{finding}; allowed: {self._max_missed - 1}"
        return ""
