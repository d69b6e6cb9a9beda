"""A shelf with one row of books: its frame and its solid parts."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from handcart.backends.simulation.world.solids import Solid
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box

from .spec import BookSpec, GapSpec, ObjectSpec, ShelfSpec

SHELF_DEPTH_M = 0.25
PANEL_THICKNESS_M = 0.02
BOARD_THICKNESS_M = 0.02
BACK_THICKNESS_M = 0.005
PANEL_HEIGHT_M = 0.35  # of the side panels above the board [m]
WOOD_GREY = 130  # grey
INNER_PARTS = ("back", "board", "left panel", "right panel")
_BOOK_END_HEIGHT = 0.16
_BOOK_END_FRONT = 0.03  # behind the board's front edge


class SimulatedShelf:
    """A simulated shelf, as a world's file describes it.

    Its frame S has the origin on top of the shelf's board, in the middle of the front edge; x points into the
    shelf, y to the left, z up. The space below the board is closed by a plinth, with its front at x = 0.
    """

    def __init__(self, spec: ShelfSpec) -> None:
        self.spec = spec
        self.name = spec.name
        self.half_width = spec.width_m / 2
        self.pose2 = Pose2(spec.x_m, spec.y_m, math.radians(spec.heading_deg))
        self.pose: Transform = self.pose2.lift(spec.board_m)
        """world_T_S (4, 4)."""
        self.inverse_pose: Transform = inverse(self.pose)
        used = sum(e.gap_mm if isinstance(e, GapSpec) else e.thickness_mm for e in spec.books) / 1e3
        self.book_end_left = self.half_width - used
        """y in S of the book end's left face, in [m]; it reaches to the right panel."""

    def standing(self) -> Iterator[tuple[BookSpec, float]]:
        """Yield the books that the world's file puts on the shelf, each with the y of its middle in the shelf
        frame S, in [m].
        """
        left = self.half_width
        for entry in self.spec.books:
            if isinstance(entry, GapSpec):
                left -= entry.gap_mm / 1e3
            else:
                yield entry, left - entry.thickness_mm / 2e3
                left -= entry.thickness_mm / 1e3

    def parts(self) -> dict[str, Box]:
        """Return all solid parts of the shelf, without books, as boxes in the world, by name of the part."""
        half, outer = self.half_width, self.half_width + PANEL_THICKNESS_M
        low = self._low
        bounds = {
            "board": ((0.0, -half, -BOARD_THICKNESS_M), (SHELF_DEPTH_M, half, 0.0)),
            "plinth": ((0.0, -half, low), (SHELF_DEPTH_M, half, -BOARD_THICKNESS_M)),
            "back": ((SHELF_DEPTH_M, -outer, low), (SHELF_DEPTH_M + BACK_THICKNESS_M, outer, PANEL_HEIGHT_M)),
            "left panel": ((0.0, half, low), (SHELF_DEPTH_M, outer, PANEL_HEIGHT_M)),
            "right panel": ((0.0, -outer, low), (SHELF_DEPTH_M, -half, PANEL_HEIGHT_M)),
        }
        if self.book_end_left > -half + 1e-3:
            bounds["book end"] = (
                (_BOOK_END_FRONT, -half, 0.0),
                (SHELF_DEPTH_M, self.book_end_left, _BOOK_END_HEIGHT),
            )
        bounds |= {
            f"object {i + 1}": self._object_ends(object_) for i, object_ in enumerate(self.spec.objects)
        }
        return {part: self._box(part, *ends) for part, ends in bounds.items()}

    def outer_box(self) -> Box:
        """Return the box in the world around the shelf, from its lowest part to the top of its panels."""
        outer = self.half_width + PANEL_THICKNESS_M
        return self._box(
            "outside", (0.0, -outer, self._low), (SHELF_DEPTH_M + BACK_THICKNESS_M, outer, PANEL_HEIGHT_M)
        )

    @property
    def _low(self) -> float:
        """Lowest z of the shelf in its frame S, in [m]."""
        return min(self.spec.closed_from_m - self.spec.board_m, -BOARD_THICKNESS_M - BACK_THICKNESS_M)

    def solids(self) -> list[Solid]:
        """Return the solids of the shelf for a world; the grey of its inner parts is multiplied by the factor
        `light` of the world's file.
        """
        greys = {part: object_.grey for part, object_ in zip(self.objects(), self.spec.objects, strict=True)}
        greys |= dict.fromkeys(INNER_PARTS, round(WOOD_GREY * self.spec.light))
        return [Solid(box, grey=greys.get(part, WOOD_GREY)) for part, box in self.parts().items()]

    def objects(self) -> list[str]:
        """Return the names of the objects on the board other than books, in the world file's order."""
        return [f"object {i + 1}" for i in range(len(self.spec.objects))]

    def _object_ends(self, each: ObjectSpec) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        left, front = self.half_width - each.at_mm / 1e3, each.front_mm / 1e3
        return (
            (front, left - each.width_mm / 1e3, 0.0),
            (front + each.depth_mm / 1e3, left, each.height_mm / 1e3),
        )

    def _box(self, part: str, low: tuple[float, ...], high: tuple[float, ...]) -> Box:
        middle = (np.array(low) + high) / 2
        x, y, z = (float(b - a) for a, b in zip(low, high, strict=True))
        return Box(self.pose @ transform(tuple(middle)), (x, y, z), f"{part} of {self.name}")

    def fixed_intervals(self) -> list[tuple[float, float, float]]:
        """Return the intervals that side panels, book end and objects occupy in the row of books.

        Returns:
            (right, left, front) of each interval: y of its right and left end, and x of its object's front,
            in the shelf frame S, in [m].
        """
        half = self.half_width
        walls = [(half, half + PANEL_THICKNESS_M, 0.0), (-half - PANEL_THICKNESS_M, -half, 0.0)]
        if self.book_end_left > -half + 1e-3:
            walls.append((-half, self.book_end_left, _BOOK_END_FRONT))
        for object_ in self.spec.objects:
            (front, right, _), (_, left, _) = self._object_ends(object_)
            walls.append((right, left, front))
        return walls
