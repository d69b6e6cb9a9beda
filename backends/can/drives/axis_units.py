"""Conversion between counts of a drive and metres or radians of its axis."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AxisUnits:
    """Counts never leave `backends/can`."""

    scale: float
    """Counts for a metre or a radian, signed."""
    zero: int = 0
    """Counts at zero."""

    def counts(self, position: float) -> int:
        """Return a position in [m] or [rad] as counts."""
        return round(position * self.scale) + self.zero

    def position(self, counts: float) -> float:
        """Return counts as a position in [m] or [rad]."""
        return (counts - self.zero) / self.scale

    def rate(self, value: float) -> int:
        """Counts/s or counts/s² for a speed or an acceleration, with its sign."""
        return round(value * self.scale)

    def size(self, value: float) -> int:
        """Return the same rate without a sign."""
        return abs(self.rate(value))

    def speed(self, counts: float) -> float:
        """Return the speed [m/s] or [rad/s] of counts/s."""
        return counts / self.scale


def unwrapped(counts: int, before: int, size: int = 2**32) -> int:
    """Return by how much counts have changed that start over after `size` of them."""
    return (counts - before + size // 2) % size - size // 2
