"""Steps of the clock by which messages are stamped: set by NTP, by hand, or after a sleep."""

from __future__ import annotations

from collections.abc import Callable

MIN_STEP_S = 0.02
"""Smallest change of a clock between two periods that is a step; slewing changes far less."""


class ClockSteps:
    """Detector of steps of a clock against a monotonic clock."""

    def __init__(self, stamps: Callable[[], float], monotonic: Callable[[], float]) -> None:
        """Take both clocks.

        Args:
            stamps: returns the time by which messages are stamped, in [s].
            monotonic: returns a time that is never set, in [s].
        """
        self._stamps, self._monotonic = stamps, monotonic
        self._bounds = self._read()

    def advance(self) -> float:
        """Return by how much the clock was set since the last call, in [s]; 0 if it was not."""
        was_low, was_high = self._bounds
        self._bounds = low, high = self._read()
        if was_high + MIN_STEP_S >= low and high + MIN_STEP_S >= was_low:
            return 0.0
        return 0.5 * (low + high - was_low - was_high)

    def _read(self) -> tuple[float, float]:
        """Return bounds of the difference of both clocks, in [s]; the program may pause between two calls."""
        before = self._monotonic()
        now = self._stamps()
        return now - self._monotonic(), now - before
