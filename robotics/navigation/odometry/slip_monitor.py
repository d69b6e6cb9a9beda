"""Detection of wheels that slip more than assumed, by the difference between headings of scans and wheels."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

WINDOW_M = 0.3  # travel of a wheel over which the turn is compared: scan noise counts for little
MAX_WINDOWS = 10
MIN_WINDOWS = 3
SCAN_TURN_VARIANCE = 2.0 * 0.003**2  # [rad²] of a turn between two scans
MAX_FACTOR = 400.0  # of the claimed variance: 20 times its sigma


class RolledWay(NamedTuple):
    """Travel of a base's wheels, summed up for left side, right side, and sideways to the left, in [m]."""

    left: float = 0.0
    right: float = 0.0
    sideways: float = 0.0

    def added(self, left: float, right: float, sideways: float) -> RolledWay:
        """Return this travel of the wheels plus further travel.

        Args:
            left: travel of the left wheels, in [m].
            right: travel of the right wheels, in [m].
            sideways: travel to the left, in [m].
        """
        return RolledWay(self.left + left, self.right + right, self.sideways + sideways)


class SlipMonitor:
    """Estimator of the wheels' slip, from the heading corrections by scans and their variance (Mehra, 1970).

    Corrections are summed up over windows of `WINDOW_M` of a wheel's travel, and the last ten windows are
    averaged. Scans determine the heading wherever a wall is seen, also along a corridor. Equal slip of both
    wheels does not change the heading; it is assumed to be as large as that of a single wheel.
    """

    STATE: ClassVar = {"_missed": float, "_claimed": float, "_rolled": float, "_ratios": tuple[float, ...]}

    def __init__(self) -> None:
        """Start with the assumed variance of slip."""
        self._missed = self._claimed = self._rolled = 0.0
        self._ratios: tuple[float, ...] = ()

    @property
    def factor(self) -> float:
        """Factor, 1 to 400, by which the slip's estimated variance exceeds the assumed one; 1 until three
        windows (sections of the travel) are complete.
        """
        if len(self._ratios) < MIN_WINDOWS:
            return 1.0
        return min(MAX_FACTOR, max(1.0, math.fsum(self._ratios) / len(self._ratios)))

    @property
    def begun(self) -> bool:
        """True if the present window, a stretch of travel over which slip is measured, has no travel yet."""
        return self._rolled == 0.0

    def roll(self, left: float, right: float, variance: float) -> None:
        """Add the wheels' travel, and the heading variance by assumed slip, to the sums of the present window
        (a section of the travel, for which slip is evaluated when it ends).

        Args:
            left: travel of the left wheels, in [m].
            right: travel of the right wheels, or sideways travel if that is more, in [m].
            variance: assumed variance of the turn by slip, in [rad²].
        """
        self._rolled += max(abs(left), abs(right))
        self._claimed += variance

    def take(self, missed: float, other: float) -> None:
        """Add a heading correction by a scan to the present window (a section of the travel). If the window
        is at least `WINDOW_M` long, evaluate its slip and start a new window.

        Args:
            missed: heading by the scan less heading by the wheels, in [rad].
            other: variance, in [rad²], of the heading's change within the window, by errors other than slip.
        """
        self._missed += missed
        if self._rolled < WINDOW_M:
            return
        beyond = max(0.0, self._missed**2 - SCAN_TURN_VARIANCE - other)
        self._ratios = (*self._ratios[1 - MAX_WINDOWS :], beyond / max(self._claimed, 1e-12))
        self.begin()

    def begin(self) -> None:
        """Start a new window of travel, and discard the sums of the present window."""
        self._missed = self._claimed = self._rolled = 0.0


def turn_variance(slip: float, length: float, left: float, right: float, tread: float) -> float:
    """Return the variance, in [rad²], of a base's turn by slip of its wheels.

    Args:
        slip: standard deviation of the relative error of each wheel's travel, which is independent after
            every `length`.
        length: distance after which the slip is independent of that before, in [m].
        left: travel of the left wheels, in [m].
        right: travel of the right wheels, in [m].
        tread: distance between the left and right wheels, in [m].
    """
    return slip**2 * length * (abs(left) + abs(right)) / tread**2 if math.isfinite(left + right) else 0.0
