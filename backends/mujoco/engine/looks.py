"""Appearance of the world that an engine received."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from handcart.backends.physics.engine.thing_form import ThingForm
from handcart.backends.simulation.world.material import Material
from handcart.backends.simulation.world.sheet import Sheet
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray, FloatArray


class BoxLook(NamedTuple):
    """Appearance of a box of the world that is immovable or moved by the program, never by forces."""

    box: Box
    grey: int
    moves: bool
    material: Material


class TileLook(NamedTuple):
    """Appearance of a square tile of rough ground, given by the heights of a grid of points, for
    rendering.
    """

    corner: FloatArray
    cell: float
    heights: FloatArray


@dataclass
class Looks:
    """Appearance of all bodies of a world, for rendering, by their numbers in the engine.

    The appearance of a body is added together with the body, and never removed.
    """

    level: bool = False
    """True if there is a level floor."""
    boxes: dict[int, BoxLook] = field(default_factory=dict)
    tiles: dict[int, TileLook] = field(default_factory=dict)
    sheets: list[Sheet] = field(default_factory=list)
    things: dict[int, ThingForm] = field(default_factory=dict)
    shown: dict[int, ByteArray] = field(default_factory=dict)
    """Grey pictures (h, w) that things show instead of those that they were made with, by the engine's
    numbers.
    """

    @property
    def count(self) -> int:
        """Number of bodies with an appearance; if it has changed, the model for rendering has to be built
        again.
        """
        return len(self.boxes) + len(self.tiles) + len(self.sheets) + len(self.things)
