"""Pieces of furniture in the room of an activity: their bodies, and their surfaces."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2

from .thing_table import FurnitureEntry

WALL_M = 0.02
"""Thickness of sides, backs and tops."""
BOTTOM_M = 0.01
"""Thickness of the bottom of a box."""
HALVED_M = 0.38
"""Greatest width of the bottom of a box that the arm serves from one place, between its walls."""
OVERLAP_M = 0.004
"""Overlap of the two halves of a box's bottom, in [m], so that a thing may be in its middle."""
SEGMENT_M = 0.62
"""Greatest width of a surface that the arm serves from one place."""


class FurniturePart(NamedTuple):
    """Solid box of a piece of furniture, such as a board or a wall."""

    name: str
    x: float
    """x of the part's middle in the frame of the piece, in [m]; the front is at -y."""
    y: float
    size: tuple[float, float, float]
    above: float = 0.0
    """Height of the part's underside above the floor, in [m]."""


class FurnitureLevel(NamedTuple):
    """Surface of a piece of furniture, or a part of the surface, that carries things."""

    name: str
    relation: str
    """Relation of the things there to the piece: `ontop`, `inside`, or `front` for next to it."""
    x: float
    """x of the surface's middle in the frame of the piece, in [m]; its front is at -y."""
    y: float
    size: tuple[float, float]
    height: float
    clearance: float | None
    walls: tuple[str, ...]
    """Sides of the surface with a wall, which reaches up to the clearance."""
    thickness: float
    """Thickness of the board under the surface, in [m]; equal to `height` if the piece is solid down to the
    floor.
    """
    wall_height: float | None = None
    """Height of the walls, in [m]; None if they reach up to the clearance."""
    ceiling: float = 0.0
    """Thickness of what is above the clearance, in [m]; 0 without a clearance."""


@dataclass(frozen=True)
class Piece:
    """A piece of furniture with its pose in the room."""

    name: str
    term: str
    entry: FurnitureEntry
    pose: Pose2
    """Pose of the middle of the piece's foot in the room; the -y side of the piece is its front."""
    base: float = 0.0
    """Height of the piece's foot above the floor, in [m]."""
    reserved: float = 0.0
    """Width at the +x end of a table for furniture on it, in [m]."""
    front: tuple[float, float] | None = None
    """Width and depth of the floor in front of the piece for things next to it, in [m], or None."""
    fronts: int = 1
    """Number of parts of the area `front`."""

    def parts(self) -> Iterator[FurniturePart]:
        """Yield the solid boxes of the piece; a box that carries things has the name of its upper surface."""
        width, depth, height = self.entry.size_m
        for level in self.levels():
            if level.thickness > 0.0:
                under = level.height - level.thickness
                yield FurniturePart(level.name, level.x, 0.0, (level.size[0], depth, level.thickness), under)
        if self.reserved > 0.0:
            x = (width - self.reserved) / 2
            yield FurniturePart(f"{self.name}_end", x, 0.0, (self.reserved, depth, height))
        if self.entry.form == "block":
            yield FurniturePart(self.name, 0.0, 0.0, (width, depth, height))
        if self.entry.form == "box":
            for side, x in (("left", -(width - WALL_M) / 2), ("right", (width - WALL_M) / 2)):
                yield FurniturePart(f"{self.name}_{side}", x, 0.0, (WALL_M, depth, height), self.base)
            for side, y in (("front", -(depth - WALL_M) / 2), ("back", (depth - WALL_M) / 2)):
                size = (width - 2 * WALL_M, WALL_M, height)
                yield FurniturePart(f"{self.name}_{side}", 0.0, y, size, self.base)
        if self.entry.form == "shelf":
            sides, high = (self.entry.size_m[0] - WALL_M) / 2, self._board + self._opening
            for side, x in (("left", -sides), ("right", sides)):
                yield FurniturePart(f"{self.name}_{side}", x, 0.0, (WALL_M, depth, high))
            back, inner = (depth - WALL_M) / 2, self.entry.size_m[0] - 2 * WALL_M
            yield FurniturePart(f"{self.name}_back", 0.0, back, (inner, WALL_M, self._opening), self._board)

    def levels(self) -> Iterator[FurnitureLevel]:
        """Yield the surfaces of the piece, in parts that the arm can each reach from one base pose."""
        width, depth, height = self.entry.size_m
        if self.front is not None:
            yield from self._before()
        if self.entry.form == "table":
            yield from self._divided(self.name, "ontop", (width - self.reserved, depth), height)
        elif self.entry.form == "floor":
            yield from self._divided(f"{self.name}_area", "ontop", (width, depth), 0.0)
        elif self.entry.form == "tray":
            size, top = (width, depth), self.base + height
            yield FurnitureLevel(self.name, "ontop", 0.0, 0.0, size, top, None, (), height)
        elif self.entry.form == "box":
            yield from self._bottom()
        elif self.entry.form == "shelf":
            inner = width - 2 * WALL_M
            size = (inner, depth - WALL_M)
            yield from self._divided(f"{self.name}_in", "inside", size, self._board, self._opening)
            yield from self._divided(f"{self.name}_top", "ontop", (width, depth), height)

    def _bottom(self) -> Iterator[FurnitureLevel]:
        """Yield the bottom of a box, in halves if it is wide: each is served from a place of its own."""
        width, depth, height = self.entry.size_m
        inner, name, bottom = width - 2 * WALL_M, f"{self.name}_in", self.base + BOTTOM_M
        count = 2 if inner > HALVED_M else 1
        for number in range(count):
            sides = ("+y", "-y", *["-x"] * (number == 0), *["+x"] * (number == count - 1))
            label = name if count == 1 else f"{name}_{number + 1}"
            size = (inner / count + (OVERLAP_M if count > 1 else 0.0), depth - 2 * WALL_M)
            x = (inner - size[0]) * (number - (count - 1) / 2)
            rim = height - BOTTOM_M
            yield FurnitureLevel(label, "inside", x, 0.0, size, bottom, None, sides, BOTTOM_M, rim)

    def _before(self) -> Iterator[FurnitureLevel]:
        """Yield the areas of the floor in front of the piece."""
        assert self.front is not None
        (width, depth), count = self.front, self.fronts
        y, height = -(self.entry.size_m[1] + depth) / 2, self.entry.size_m[2]
        for number in range(count):
            x, name = (number + 0.5) / count * width - width / 2, f"{self.name}_before_{number + 1}"
            size = (width / count, depth)
            yield FurnitureLevel(name, "front", x, y, size, 0.0, None, ("+y",), 0.0, height)

    def in_room(self, x: float, y: float) -> Pose2:
        """Return the pose in the room of a point of the piece, with the heading of the piece.

        Args:
            x: x of the point in the piece's frame, in [m].
            y: y of the point in the piece's frame, in [m]; the front is at -y.
        """
        return self.pose.compose(Pose2(x, y, 0.0))

    @property
    def _board(self) -> float:
        return self.entry.board_m or 0.0

    @property
    def _opening(self) -> float:
        return self.entry.opening_m or 0.0

    def _divided(
        self,
        name: str,
        relation: str,
        size: tuple[float, float],
        height: float,
        clearance: float | None = None,
    ) -> Iterator[FurnitureLevel]:
        width, depth = size
        count = math.ceil(width / SEGMENT_M)
        back = (self.entry.size_m[1] - depth) / 2
        for number in range(count):
            x = (number + 0.5) / count * width - width / 2 - self.reserved / 2
            label = name if count == 1 else f"{name}_{number + 1}"
            sides = ("+y", *["-x"] * (number == 0), *["+x"] * (number == count - 1))
            walls = () if clearance is None else sides
            is_top = self.entry.form == "shelf" and clearance is None
            thick = height - self._board - self._opening if is_top else height
            ceiling = 0.0 if clearance is None else self.entry.size_m[2] - height - clearance
            place = (x, -back, (width / count, depth), height)
            yield FurnitureLevel(label, relation, *place, clearance, walls, thick, None, ceiling)
