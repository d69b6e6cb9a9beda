"""The clock of hardware."""

from __future__ import annotations

import time
from collections.abc import Callable


class Pace:
    """Waits until a period of the wall clock is over.

    Late, it begins anew from then on: periods that were missed are not made up for by shorter ones.
    """

    def __init__(
        self,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Begin.

        Args:
            period: in [s].
            clock: gives the time in [s].
            sleep: waits so many seconds.
        """
        self._period, self._clock, self._sleep = period, clock, sleep
        self._end = clock() + period
        self.late = 0
        """How many periods were over before they were waited for."""

    def wait(self) -> None:
        """Wait for the end of the current period; the next one begins."""
        now = self._clock()
        if now <= self._end:
            self._sleep(self._end - now)
            self._end += self._period
        else:
            self.late += 1
            self._end = now + self._period
