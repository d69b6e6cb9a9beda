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
SEGMENT_M = 0.62
"""Greatest width of a surface that the arm serves from one place."""


class FurniturePart(NamedTuple):
    """A solid box of a piece of furniture."""

    name: str
    x: float
    """Of its middle in the frame of the piece, in [m]; -y is the front."""
    y: float
    size: tuple[float, float, float]
    above: float = 0.0
    """Height of its underside, in [m]."""


class FurnitureLevel(NamedTuple):
    """A surface that carries things, or a part of one."""

    name: str
    relation: str
    """Relation of the things there to the piece: `ontop` or `inside`."""
    x: float
    """Of its middle in the frame of the piece, in [m]."""
    y: float
    size: tuple[float, float]
    height: float
    clearance: float | None
    walls: tuple[str, ...]
    """Sides with a wall up to the clearance."""
    thickness: float
    """Of what carries it; as its height where it is solid down to the floor."""
    wall_height: float | None = None
    """Of its walls; None where they reach up to the clearance."""


@dataclass(frozen=True)
class Piece:
    """A piece of furniture with its pose in the room."""

    name: str
    term: str
    entry: FurnitureEntry
    pose: Pose2
    """Of the middle of its foot; its -y side is its front."""

    def parts(self) -> Iterator[FurniturePart]:
        """Yield its solid boxes; one that carries things has the name of that surface."""
        depth = self.entry.size_m[1]
        for level in self.levels():
            under = level.height - level.thickness
            yield FurniturePart(level.name, level.x, 0.0, (level.size[0], depth, level.thickness), under)
        if self.entry.form == "box":
            width, _, height = self.entry.size_m
            for side, x in (("left", -(width - WALL_M) / 2), ("right", (width - WALL_M) / 2)):
                yield FurniturePart(f"{self.name}_{side}", x, 0.0, (WALL_M, depth, height))
            for side, y in (("front", -(depth - WALL_M) / 2), ("back", (depth - WALL_M) / 2)):
                yield FurniturePart(f"{self.name}_{side}", 0.0, y, (width - 2 * WALL_M, WALL_M, height))
        if self.entry.form == "shelf":
            sides, high = (self.entry.size_m[0] - WALL_M) / 2, self._board + self._opening
            for side, x in (("left", -sides), ("right", sides)):
                yield FurniturePart(f"{self.name}_{side}", x, 0.0, (WALL_M, depth, high))
            back, inner = (depth - WALL_M) / 2, self.entry.size_m[0] - 2 * WALL_M
            yield FurniturePart(f"{self.name}_back", 0.0, back, (inner, WALL_M, self._opening), self._board)

    def levels(self) -> Iterator[FurnitureLevel]:
        """Yield its surfaces, divided into parts that the arm serves from one place each."""
        width, depth, height = self.entry.size_m
        if self.entry.form == "table":
            yield from self._divided(self.name, "ontop", (width, depth), height)
        elif self.entry.form == "box":
            size, walls = (width - 2 * WALL_M, depth - 2 * WALL_M), ("+x", "-x", "+y", "-y")
            name = f"{self.name}_in"
            yield FurnitureLevel(
                name, "inside", 0.0, 0.0, size, BOTTOM_M, None, walls, BOTTOM_M, height - BOTTOM_M
            )
        elif self.entry.form == "shelf":
            inner = width - 2 * WALL_M
            size = (inner, depth - WALL_M)
            yield from self._divided(f"{self.name}_in", "inside", size, self._board, self._opening)
            yield from self._divided(f"{self.name}_top", "ontop", (width, depth), height)

    def in_room(self, x: float, y: float) -> Pose2:
        """Return the pose in the room of a point of the piece, with the heading of the piece."""
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
            x = (number + 0.5) / count * width - width / 2
            label = name if count == 1 else f"{name}_{number + 1}"
            sides = ("+y", *["-x"] * (number == 0), *["+x"] * (number == count - 1))
            walls = () if clearance is None else sides
            is_top = self.entry.form == "shelf" and clearance is None
            thick = height - self._board - self._opening if is_top else height
            yield FurnitureLevel(
                label, relation, x, -back, (width / count, depth), height, clearance, walls, thick
            )
