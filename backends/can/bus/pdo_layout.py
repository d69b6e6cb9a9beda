"""Objects that are sent over the bus each period."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

AT_ONCE, ON_SYNC = 255, 1
"""Transmission types (CiA 301) of a PDO that takes effect on arrival, or with the next SYNC."""
PROFILE_POSITION, PROFILE_VELOCITY, CYCLIC_POSITION, CYCLIC_VELOCITY = 1, 3, 8, 9
"""Modes of operation (6060h)."""
CIA402_MODES = {
    ("velocity", "profile"): PROFILE_VELOCITY,
    ("velocity", "csv"): CYCLIC_VELOCITY,
    ("position", "profile"): PROFILE_POSITION,
    ("position", "csp"): CYCLIC_POSITION,
}
"""Modes of operation, by the commanded quantity and the mode's name in the robot's file."""
OBJECT_BITS = {
    0x6040: 16,
    0x6041: 16,
    0x603F: 16,
    0x6061: 8,
    0x6064: 32,
    0x606C: 32,
    0x6077: 16,
    0x607A: 32,
    0x6081: 32,
    0x60FF: 32,
}


class Pdo(NamedTuple):
    """A PDO: one frame of process data with its mapped objects."""

    number: int
    """Number of the PDO, from 1."""
    objects: tuple[int, ...]
    """Objects mapped into the PDO, in order."""
    transmission: int

    @property
    def length(self) -> int:
        """Length of the data in [bytes]."""
        return sum(OBJECT_BITS[object_] for object_ in self.objects) // 8


class Layout(NamedTuple):
    """Mapping of one drive's PDOs, which are the objects in its command frames and in its answer frames."""

    commands: tuple[Pdo, ...]
    """PDOs that the drive receives, COB-IDs 200h, 300h ... + node; all but the first are sent on change."""
    answers: tuple[Pdo, ...]
    """PDOs that the node sends after each SYNC, COB-IDs 180h, 280h ... + node."""


_ANSWERS = (Pdo(1, (0x6041, 0x6064, 0x6061), ON_SYNC), Pdo(2, (0x606C, 0x6077, 0x603F), ON_SYNC))


def layout(mode: int, left_out: Collection[int] = ()) -> Layout:
    """Return the PDOs that a drive needs in a mode of operation, with the objects in each.

    Args:
        mode: mode of operation (6060h).
        left_out: indices of objects that the drive lacks, and which are left out of its answers.
    """
    target = 0x607A if mode in (PROFILE_POSITION, CYCLIC_POSITION) else 0x60FF
    when = ON_SYNC if mode in (CYCLIC_POSITION, CYCLIC_VELOCITY) else AT_ONCE
    command = Pdo(1, (0x6040, target), when)
    answers = tuple(
        answer._replace(objects=tuple(index for index in answer.objects if index not in left_out))
        for answer in _ANSWERS
    )
    if mode == PROFILE_POSITION:
        return Layout((command, Pdo(2, (0x6081,), AT_ONCE)), answers)
    return Layout((command,), answers)
