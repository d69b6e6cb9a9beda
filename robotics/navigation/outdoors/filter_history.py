"""Values that a filter of fixes keeps in order to undo some of them, and what a fix led to."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from handcart.robotics.navigation.odometry.watched_moment import Belief, WatchedMoment
from handcart.robotics.navigation.outdoors.smoothing import Entries
from handcart.robotics.numerics.arrays import FloatArray


class FilterRequest(Enum):
    """Request to an outdoor filter between two of its steps, either to mark this time, so that the smoother
    estimates the pose for it, or to measure the displacement from this time on.
    """

    MARK = "mark"
    ORIGIN = "origin"


class FilterMoment(NamedTuple):
    """Stored state of a filter as it was before a fix, from which the filter can be restored."""

    belief: Belief
    rested: bool
    still: FloatArray
    """(2,) turn in [rad] and time in [s] at rest since the gyro's bias was last corrected."""
    entries: Entries
    origin: WatchedMoment | None


class FixResult(NamedTuple):
    """Result of updating a filter with a GNSS fix, which says whether the fix was accepted, and how likely it
    was.
    """

    believed: bool
    log_likelihood: float
    """Logarithm of the fix's likelihood before the update, under the filter's noise model."""
    square: float
    """Squared Mahalanobis distance of the fix to its expected position, 2 on average."""
    why: str = ""
    """Reason why the fix was not believed, in words; empty if it was."""
