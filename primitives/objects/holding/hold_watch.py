"""Objects that slip out of the hand while it carries them."""

from __future__ import annotations

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Measured, NeedsPerson
from handcart.primitives.restoring.snapshot import is_holding

MAX_MISSED_PERIODS = 4


class HoldWatch:
    """Watch over the fingers that hold an object; asked once a period."""

    def __init__(self) -> None:
        self._missed = 0

    def has_slipped(self, robot: Robot) -> bool:
        """Return whether the fingers have held nothing for `MAX_MISSED_PERIODS` periods."""
        self._missed = 0 if is_holding(robot) else self._missed + 1
        return self._missed >= MAX_MISSED_PERIODS

    def slipped(self, robot: Robot) -> NeedsPerson:
        """Return the error for an object that is no longer in the hand, with the opening of the fingers."""
        opening = Measured("Gripper", "opening", 1e3 * robot.gripper.width(), unit="mm")
        return NeedsPerson("the object slipped out of the hand", opening, cause=causes.SLIPPED)
