"""What a primitive means to touch."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Literal, NamedTuple

RobotPart = Literal["base", "arm", "hand", "held"]
"""Base with what is mounted on it; links before the hand; the hand with its fingers; what it holds."""


class MeantContact(NamedTuple):
    """A part of the robot, and what it is to touch: by its name in the world, `*` for any characters."""

    part: RobotPart
    other: str

    def covers(self, part: str, other: str) -> bool:
        """Whether this contact is meant."""
        return part == self.part and fnmatchcase(other, self.other)
