"""Base class of sensors that send readings by themselves."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from .sensor_errors import StaleSensor

Clock = Callable[[], float]


class LiveSensor(ABC):
    """Base class of real sensors that send readings by themselves.

    `advance` processes the readings of a control period; it never waits and never raises. If a sensor stops
    sending, its last reading becomes stale, and the next access raises `StaleSensor`.
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
        """Reason why the sensor cannot be read any more; "" while it can."""
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
        """Age of the last plausible reading at the start of this period, in [s]; None before the first."""
        return None if self._came is None else self._now - self._came

    @property
    def is_fresh(self) -> bool:
        """True if the sensor has sent a plausible reading, and the last one is not older than the robot's
        file allows.
        """
        age = self.age
        return age is not None and age <= self._stale

    def check_fresh(self) -> None:
        """Raise `StaleSensor` if the last good reading is older than allowed, or none has arrived."""
        if not self.is_fresh:
            raise StaleSensor(self.name, self.age, self._stale, self.trouble or self.doubt)

    def _good(self) -> None:
        """Note that a good reading arrived in this period."""
        self._came = self._now
