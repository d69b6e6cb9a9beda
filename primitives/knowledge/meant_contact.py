"""Intended contacts of a primitive."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Literal, NamedTuple

RobotPart = Literal["base", "arm", "hand", "held"]
"""Part of the robot (base with mounted parts, links before the hand, hand with fingers, held object)."""


class MeantContact(NamedTuple):
    """Contact that a motion intends, between a part of the robot and a body in the simulated world.

    The name `other` of the body may contain `*` for any characters.
    """

    part: RobotPart
    other: str

    def covers(self, part: str, other: str) -> bool:
        """Return whether a contact that occurred is this intended one.

        Args:
            part: part of the robot, one of `RobotPart`.
            other: name of the touched body in the world.
        """
        return part == self.part and fnmatchcase(other, self.other)
