"""Materials of surfaces, in pictures for people."""

from __future__ import annotations

from typing import NamedTuple


class Material(NamedTuple):
    """Appearance of a surface in pictures for people; the robot's camera sees greys (see `Thing.grey`)."""

    red: float
    """Share of red light that it reflects, 0 to 1; green and blue alike."""
    green: float
    blue: float
    shine: float = 0.1
    """Share of a lamp's light that it mirrors, 0 to 1."""


PLASTER_MATERIAL = Material(0.86, 0.84, 0.80, 0.0)
WOOD_MATERIAL = Material(0.66, 0.47, 0.31, 0.15)
PALE_WOOD = Material(0.80, 0.66, 0.47, 0.15)
LACQUER_MATERIAL = Material(0.36, 0.43, 0.50, 0.3)
