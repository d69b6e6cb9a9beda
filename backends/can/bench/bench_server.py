"""A bench as a server, used by a program in another process."""

from __future__ import annotations

import time
from collections.abc import Callable

from .bench import Bench

_PATIENCE = 1.5  # periods without a SYNC after which time passes by the clock
_CATCH_UP = 10  # periods at most that are made up for at once
_SLICES = 10  # of a period, in which time passes then

Look = Callable[[Bench], object]


class BenchServer:
    """Server that runs a bench (simulated CAN drives) in real time for a program in another process.

    Each received SYNC advances the simulated drives by one control period. If no SYNCs arrive, they advance
    with the wall clock, so that they notice a silent master as real drives do.
    """

    def __init__(
        self,
        bench: Bench,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        look: Look | None = None,
    ) -> None:
        """Prepare a server for a bench.

        Args:
            bench: on a bus of its own, not on one in this process.
            period: control period of the robot, in [s].
            clock: gives the time in [s].
            look: function that is called with the bench after each period; None: no function.
        """
        self._bench, self._period, self._clock, self._look = bench, period, clock, look
        self._seen = bench.time
        self._passed = clock()
        """Time of `clock` up to which the bench has advanced, in [s]."""
        self._alone = False
        """True while no SYNCs come."""
        # A simulated robot knows whole periods only.
        self._slice = period / _SLICES if bench.inner is None else period

    def serve(self, until: Callable[[], bool]) -> None:
        """Serve the clients until `until()` returns True; `until` is called at least once in a control
        period.
        """
        while not until():
            self._bench.line.wait(self._has_passed, self._slice / 2 if self._alone else self._period / 2)
            self.catch_up()

    def catch_up(self) -> None:
        """Advance the simulated drives to the present time of the clock if no SYNCs have arrived for 1.5
        periods.
        """
        now = self._clock()
        if self._has_passed():
            self._alone, self._passed = False, now
            self._note()
        self._alone = self._alone or now - self._passed > _PATIENCE * self._period
        if not self._alone:
            return
        # Skip the periods that this machine was too slow for.
        self._passed = max(self._passed, now - _CATCH_UP * self._period)
        while now - self._passed >= self._slice:
            self._passed += self._slice
            self._bench.tick(self._slice)
            self._note()

    def _has_passed(self) -> bool:
        return self._bench.time != self._seen

    def _note(self) -> None:
        self._seen = self._bench.time
        if self._look is not None:
            self._look(self._bench)
