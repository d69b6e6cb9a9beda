"""Conversion between counts of a drive and metres or radians of its axis."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AxisUnits:
    """Conversion between a drive's position in counts and the axis' position in [m] or [rad].

    Counts are used only in `backends/can`.
    """

    scale: float
    """Counts for a metre or a radian; negative if the drive counts down where the axis' position grows."""
    zero: int = 0
    """Counts of the drive where the axis' position is 0."""

    def counts(self, position: float) -> int:
        """Return an axis' position, given in [m] or [rad], as the drive's position in counts."""
        return round(position * self.scale) + self.zero

    def position(self, counts: float) -> float:
        """Return a drive's position in counts as the axis' position in [m] or [rad]."""
        return (counts - self.zero) / self.scale

    def rate(self, value: float) -> int:
        """Return a speed or acceleration in signed counts.

        It is given in [m] or [rad] per s or s², and returned in counts per s or s².
        """
        return round(value * self.scale)

    def size(self, value: float) -> int:
        """Return the absolute value of a speed or acceleration, converted to encoder counts.

        The value is in [m] or [rad] per s or s²; the result is in counts per s or s².
        """
        return abs(self.rate(value))

    def speed(self, counts: float) -> float:
        """Return a drive's speed, given in [counts/s], as the axis' speed in [m/s] or [rad/s]."""
        return counts / self.scale


def unwrapped(counts: int, before: int, size: int = 2**32) -> int:
    """Return the signed change of a wrapping counter since an earlier reading, at most half of its range.

    Args:
        counts: reading now.
        before: earlier reading.
        size: number of counts after which the counter starts over.
    """
    return (counts - before + size // 2) % size - size // 2
