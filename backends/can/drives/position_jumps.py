"""Test whether a position can follow the one before, by the drive's reported speed."""

from __future__ import annotations

import math
from collections import deque

from .axis_limits import AxisLimits

_LOOKS_BACK = 3  # periods whose speeds count: a command may act two periods late
_NOISE = 0.1  # of the window of the following error
_FREE = 0.02  # of the travel, where an axis may be blocked and has no window
_MIN_BITS, _MAX_BITS = 8, 31  # of encoders
_LIKE = 0.02  # share by which a jump may differ from the range of an encoder


class PositionJumps:
    """Plausibility test of the difference between two successive measured positions of a drive.

    The difference, in [counts] of the encoder, must lie between no motion and twice the motion at the highest
    speed that was reported or commanded in the last three periods; twice, because periods differ in length.
    When an encoder's count wraps, it jumps against the direction of motion, so the test finds even jumps
    smaller than the window of the following error.
    """

    def __init__(self, limits: AxisLimits, scale: float, period: float) -> None:
        """Begin at rest.

        Args:
            limits: limits of the axis.
            scale: counts for a metre or a radian, of either sign.
            period: control period, in [s].
        """
        free = _FREE * (limits.upper - limits.lower)
        noise = _NOISE * limits.window if math.isfinite(limits.window) else free
        self._noise = noise * abs(scale) + 2.0
        self._period = period
        self._speeds: deque[float] = deque(maxlen=2 * _LOOKS_BACK)

    def note(self, reported: float, commanded: float) -> None:
        """Record the speeds of a period; they limit which position differences are plausible in the next
        periods.

        Args:
            reported: speed that the drive reports, in [counts/s].
            commanded: speed of the command, in [counts/s].
        """
        self._speeds += (reported, commanded)

    def excess(self, moved: int, periods: int) -> float:
        """Return the encoder counts by which a travel is above the range that is plausible for the latest
        speeds; negative if it is below this range, 0 within it.

        Args:
            moved: signed difference of two measured positions, in [counts].
            periods: number of periods between the two positions.
        """
        reach = 2.0 * self._period * (periods + 1)
        lowest = min(0.0, *self._speeds) * reach - self._noise
        highest = max(0.0, *self._speeds) * reach + self._noise
        return moved - min(max(float(moved), lowest), highest)

    def forget(self) -> None:
        """Forget all recorded speeds, because the axis was set to rest at another position."""
        self._speeds.clear()


def encoder_bits(jump: float, uncertainty: float) -> int | None:
    """Return the number of bits b of an encoder whose wrap explains a position jump, which is then about 2^b
    counts.

    None if no number of bits from 8 to 31 explains the jump.

    Args:
        jump: jump of the position, in [counts], of either sign.
        uncertainty: largest error of the jump, in [counts].
    """
    if abs(jump) < 1.0:
        return None
    bits = round(math.log2(abs(jump)))
    off = abs(abs(jump) - 2.0**bits)
    is_like = off <= uncertainty + _LIKE * 2.0**bits and 4.0 * uncertainty < 2.0**bits
    return bits if _MIN_BITS <= bits <= _MAX_BITS and is_like else None
