"""Two nodes that send one quantity, found by readings that alternate."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

KEPT_READINGS = 60
MAX_DEVIATIONS = 5
"""Number of the last `KEPT_READINGS` readings that may deviate, as single spikes do."""


class Alternation(NamedTuple):
    """Deviation of readings that alternate."""

    number: int
    """Number of the value that deviates most from its limit."""
    size: float
    """Largest deviation of this value, in its unit."""


class AlternationWatch:
    """Detector of two senders of one quantity whose values differ by less than a jump.

    A reading is compared with the interpolation of the readings before and after it. A reading of one sender
    deviates by less than the motion between these two, however it accelerates, is corrected or is stamped
    late. The readings of two senders go there and back.
    """

    def __init__(self, limits: Sequence[float]) -> None:
        """Begin without a reading.

        Args:
            limits: (n,) deviation of each value that is always allowed; infinite for one that may jump.
        """
        self._limits = limits
        self._readings: list[tuple[float, Sequence[float]]] = []
        self._deviations: deque[Alternation | None] = deque(maxlen=KEPT_READINGS)

    def note(self, stamp: float, values: Sequence[float]) -> Alternation | None:
        """Note a reading, and return the largest of too many deviations; None without these.

        A reading whose stamp is not later than that of the reading before is ignored.

        Args:
            stamp: time of the reading, in [s].
            values: (n,) values of the reading.
        """
        if self._readings and stamp <= self._readings[-1][0]:
            return None
        self._readings = [*self._readings[-2:], (stamp, values)]
        if len(self._readings) < 3:
            return None
        self._deviations.append(self._deviation())
        found = [item for item in self._deviations if item is not None]
        if len(found) <= MAX_DEVIATIONS:
            return None
        return max(found, key=self._excess)

    def _deviation(self) -> Alternation | None:
        """Return the worst deviation of the last but one reading; None if all are allowed."""
        (begin, before), (middle, at), (end, after) = self._readings
        share = (middle - begin) / (end - begin)
        found = []
        for number, limit in enumerate(self._limits):
            moved = after[number] - before[number]
            size = abs(at[number] - before[number] - share * moved)
            if size > limit + abs(moved):
                found.append(Alternation(number, size))
        return max(found, key=self._excess, default=None)

    def _excess(self, found: Alternation) -> float:
        return found.size / self._limits[found.number]

    def forget(self) -> None:
        """Discard all readings."""
        self._readings = []
        self._deviations.clear()
