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
    """Travel of the wheels, in [m]."""

    left: float = 0.0
    right: float = 0.0
    sideways: float = 0.0

    def added(self, left: float, right: float, sideways: float) -> RolledWay:
        """Return the travel after further travel of the wheels.

        Args:
            left: travel of the left wheels, in [m].
            right: travel of the right wheels, in [m].
            sideways: travel to the left, in [m].
        """
        return RolledWay(self.left + left, self.right + right, self.sideways + sideways)


class SlipMonitor:
    """Estimator of the wheels' slip, by the turns that scans correct and their variance (Mehra, 1970).

    Turns are summed up over windows of `WINDOW_M` of a wheel's travel, and the last ten windows are averaged.
    Scans determine the heading wherever a wall is seen, also along a corridor. Slip of both wheels alike does
    not show in the heading; it is assumed to be as large as that of a single wheel.
    """

    STATE: ClassVar = {"_missed": float, "_claimed": float, "_rolled": float, "_ratios": tuple[float, ...]}

    def __init__(self) -> None:
        """Start with the assumed variance of slip."""
        self._missed = self._claimed = self._rolled = 0.0
        self._ratios: tuple[float, ...] = ()

    @property
    def factor(self) -> float:
        """Factor of the slip's variance relative to the assumed one, 1 to 400; 1 before three windows."""
        if len(self._ratios) < MIN_WINDOWS:
            return 1.0
        return min(MAX_FACTOR, max(1.0, math.fsum(self._ratios) / len(self._ratios)))

    @property
    def begun(self) -> bool:
        """True if a new window of travel has just begun."""
        return self._rolled == 0.0

    def roll(self, left: float, right: float, variance: float) -> None:
        """Count the wheels' travel, and the variance that slip is assumed to add by it.

        Args:
            left: travel of the left wheels, in [m].
            right: travel of the right wheels, or sideways travel if that is more, in [m].
            variance: assumed variance of the turn by slip, in [rad²].
        """
        self._rolled += max(abs(left), abs(right))
        self._claimed += variance

    def take(self, missed: float, other: float) -> None:
        """Count a turn that a scan found the wheels to have missed; start a new window after a full one.

        Args:
            missed: heading by the scan less heading by the wheels, in [rad].
            other: variance in [rad²] of the turn in the window for other reasons than slip.
        """
        self._missed += missed
        if self._rolled < WINDOW_M:
            return
        beyond = max(0.0, self._missed**2 - SCAN_TURN_VARIANCE - other)
        self._ratios = (*self._ratios[1 - MAX_WINDOWS :], beyond / max(self._claimed, 1e-12))
        self.begin()

    def begin(self) -> None:
        """Start a new window of travel, and drop the counts of the present one."""
        self._missed = self._claimed = self._rolled = 0.0


def turn_variance(slip: float, length: float, left: float, right: float, tread: float) -> float:
    """Return the variance in [rad²] of a turn by slip.

    Args:
        slip: relative error (sigma) of each wheel's travel, new every `length`.
        length: distance after which the slip is new, in [m].
        left: travel of the left wheels, in [m].
        right: travel of the right wheels, in [m].
        tread: distance of the wheels, in [m].
    """
    return slip**2 * length * (abs(left) + abs(right)) / tread**2 if math.isfinite(left + right) else 0.0
