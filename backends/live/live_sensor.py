"""Base class of sensors that send readings by themselves."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from .sensor_errors import StaleSensor

Clock = Callable[[], float]


class LiveSensor(ABC):
    """Sensor that receives, once a period, the readings that have arrived, and knows their age.

    `advance` never waits and never raises; readings of a lost sensor grow old, and the next access raises
    a `StaleSensor`.
    """

    def __init__(self, name: str, stale: float, clock: Clock = time.monotonic) -> None:
        """Begin without a reading.

        Args:
            name: name of the sensor, for people.
            stale: age in [s] beyond which a reading is stale.
            clock: gives the time in [s].
        """
        self.name, self._stale, self._clock = name, stale, clock
        self._came: float | None = None
        self._now = clock()
        self.rejected = 0
        """Number of dropped readings: damaged, not finite, of another size, out of order."""
        self.trouble = ""
        """Reason why the sensor can't be read any more; "" while it can."""
        self.doubt = ""
        """Reason why arriving readings are not used just now; "" while they are."""

    def advance(self) -> None:
        """Read the data that arrived in the last period."""
        self._now = self._clock()
        self._take_in()

    @abstractmethod
    def _take_in(self) -> None:
        """Read the data that have arrived in this period; never wait, never raise."""

    @abstractmethod
    def close(self) -> None:
        """Close the device; a second call does nothing."""

    @property
    def age(self) -> float | None:
        """Return the age of the last good reading in this period [s]; None before the first."""
        return None if self._came is None else self._now - self._came

    @property
    def is_fresh(self) -> bool:
        """True if the last reading is not stale."""
        age = self.age
        return age is not None and age <= self._stale

    def check_fresh(self) -> None:
        """Raise `StaleSensor` if the last reading is too old."""
        if not self.is_fresh:
            raise StaleSensor(self.name, self.age, self._stale, self.trouble or self.doubt)

    def _good(self) -> None:
        """Note that a good reading arrived in this period."""
        self._came = self._now
