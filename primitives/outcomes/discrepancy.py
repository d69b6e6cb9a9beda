"""Exceptions of a primitive when the world contradicts its model."""

from __future__ import annotations

from typing import NamedTuple

from .cause_kind import CauseKind
from .causes import UNNAMED


class Measured(NamedTuple):
    """Sensor reading that decided the outcome of an action, with the limit that it was compared with."""

    sensor: str
    """Capability of the reading: RangeSensor, Camera, Arm ..."""
    what: str
    """Name of the measured quantity for people."""
    value: float | None = None
    """Measured value; None if the sensor showed nothing."""
    limit: float | None = None
    """Limit that `value` had to reach, or not to exceed; None if any value would have done."""
    unit: str = ""
    """Unit of value and limit; empty for counts and shares."""


class MotionBroken(Exception):
    """Base class of the exceptions that end a motion early.

    Attributes:
        reason: message for people.
        measured: the deciding reading, if any.
        check: name of the check that failed; empty if a method of the primitive failed, because the traceback
            names the method.
        cause: kind of cause, one of those that the primitive's package declares.
    """

    def __init__(
        self, reason: str, measured: Measured | None = None, check: str = "", *, cause: CauseKind = UNNAMED
    ) -> None:
        super().__init__(reason)
        self.reason, self.measured, self.check, self.cause = reason, measured, check, cause


class NeedsPerson(MotionBroken):
    """Exception: only a person can help; the robot stops where it is and gives up."""


class Discrepancy(MotionBroken):
    """Exception: a primitive's motion cannot continue; the framework moves back to the state at its start,
    measures whether it is reached, and reports Fail (or GiveUp if not).

    Attributes:
        permanent: True if another attempt is pointless; the action's attempts are used up.
    """

    def __init__(
        self,
        reason: str,
        permanent: bool = False,
        measured: Measured | None = None,
        check: str = "",
        *,
        cause: CauseKind = UNNAMED,
    ) -> None:
        super().__init__(reason, measured, check, cause=cause)
        self.permanent = permanent
