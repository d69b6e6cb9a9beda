"""Intended contacts of a primitive."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Literal, NamedTuple

RobotPart = Literal["base", "arm", "hand", "held"]
"""Part of the robot (base with mounted parts, links before the hand, hand with fingers, held object)."""


class MeantContact(NamedTuple):
    """Intended contact: a part of the robot, and the name of the touched body in the world, `*` for any
    characters.
    """

    part: RobotPart
    other: str

    def covers(self, part: str, other: str) -> bool:
        """Return whether a contact is intended.

        Args:
            part: part of the robot, one of `RobotPart`.
            other: name of the touched body in the world.
        """
        return part == self.part and fnmatchcase(other, self.other)
