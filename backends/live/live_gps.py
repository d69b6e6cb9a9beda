"""Base class of real satellite receivers."""

from __future__ import annotations

import time

from typing_extensions import override

from handcart.backends.capabilities.gps import Fix, Gps

from .live_sensor import Clock, LiveSensor
from .sensor_errors import StaleSensor

MIN_SILENT_PERIODS = 2.0
"""Periods of the receiver without an answer that are no silence, whatever `stale_ms` is."""


class LiveGps(LiveSensor, Gps):
    """Base class of satellite receivers that send fixes, or state that they have none.

    A receiver without a fix is no fault, however long. One from which no usable message comes is silent:
    `fix` raises `StaleSensor` then.
    """

    def __init__(self, name: str, stale: float, clock: Clock = time.monotonic) -> None:
        """Begin without a fix.

        Args:
            name: name of the receiver, for people.
            stale: time in [s] without an answer beyond which the receiver is silent.
            clock: gives the time in [s].
        """
        super().__init__(name, stale, clock)
        self._fix: Fix | None = None
        self._answered: float | None = None
        self._waits_since = self._now
        self._silence = stale

    def set_period(self, period_s: float) -> None:
        """Set the time between two fixes by the robot's file, in [s]: a slow receiver is not silent."""
        self._silence = max(self._stale, MIN_SILENT_PERIODS * period_s)

    @override
    def fix(self) -> Fix | None:
        """Return the fix that arrived in the current control period; None if none arrived.

        Raises:
            StaleSensor: the receiver has neither sent a fix nor that it has none for too long.
        """
        since = self._waits_since if self._answered is None else self._answered
        if self._now - since > self._silence:
            age = None if self._answered is None else self._now - self._answered
            raise StaleSensor(self.name, age, self._silence, self.trouble or self.doubt)
        return self._fix

    def _answer(self, fix: Fix | None) -> None:
        """Note that the receiver answered in this period: a fix, or None if it has none."""
        self._answered, self._fix = self._now, fix
        if fix is not None:
            self._good()
