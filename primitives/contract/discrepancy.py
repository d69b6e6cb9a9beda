"""What a primitive raises when the world isn't as its model says."""

from __future__ import annotations

from typing import NamedTuple


class Measured(NamedTuple):
    """The reading that decided, and what was allowed."""

    sensor: str
    """Which capability it comes from: RangeSensor, Camera, Arm ..."""
    what: str
    """What the number is, in words."""
    value: float | None = None
    """None where the sensor showed nothing."""
    limit: float | None = None
    """What `value` would have had to reach, or not to pass; None where any value would have done."""
    unit: str = ""
    """Of both; empty for a number of things or a share."""


class Discrepancy(Exception):
    """The motion can't go on as it is: the framework restores, measures, and reports Fail (or GiveUp).

    Attributes:
        reason: in words that a person understands.
        permanent: trying again makes no sense; the action's attempts are used up.
        measured: the reading that decided, where one did.
        check: who found it, where that isn't one of the primitive's methods.
    """

    def __init__(
        self, reason: str, permanent: bool = False, measured: Measured | None = None, check: str = ""
    ) -> None:
        super().__init__(reason)
        self.reason = reason
        self.permanent = permanent
        self.measured = measured
        self.check = check


class NeedsPerson(Exception):
    """Only a person can help: the robot stops where it is and gives up.

    Attributes:
        reason: in words that a person understands.
        measured: the reading that decided, where one did.
        check: who found it, where that isn't one of the primitive's methods.
    """

    def __init__(self, reason: str, measured: Measured | None = None, check: str = "") -> None:
        super().__init__(reason)
        self.reason = reason
        self.measured = measured
        self.check = check
