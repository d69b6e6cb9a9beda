"""What a primitive means to touch."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Literal, NamedTuple

from handcart.primitives.knowledge.place import Book

RobotPart = Literal["base", "arm", "hand", "held"]
"""Base with what is mounted on it; links before the hand; the hand with its fingers; what it holds."""


class MeantContact(NamedTuple):
    """A part of the robot, and what it is to touch: by its name in the world, `*` for any characters."""

    part: RobotPart
    other: str

    def covers(self, part: str, other: str) -> bool:
        """Whether this contact is meant."""
        return part == self.part and fnmatchcase(other, self.other)


def name_of_book(book: Book) -> str:
    """How the world calls it."""
    return f"book {book.accession}"


def name_of_block(number: int) -> str:
    """How the world calls a block of a plan, or a sensor."""
    return f"block {number}"
