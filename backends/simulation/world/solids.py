"""Upright solid boxes: walls, furniture, surprises, tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handcart.robotics.geometry.footprint import Footprint, polygon_gap
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .material import LACQUER_MATERIAL, PLASTER_MATERIAL, WOOD_MATERIAL, Material
from .world_file import Furniture, Surprise, TableSpec, Wall, WorldFile

WALL_HEIGHT = 2.0
MIN_BODY_HEIGHT_M = 0.02
"""Height above the floor from which a robot's or person's body may touch a solid."""
_WIDE = 4000.0  # [m]
_FOREVER = math.inf


@dataclass(frozen=True, eq=False)
class Solid:
    """Box with upright sides, and the simulated times at which it is present, in [s]."""

    box: Box
    appears: float = 0.0
    leaves: float = _FOREVER
    grey: int | None = None
    """Grey of its sides, 0 to 255; None: that of furniture."""

    @property
    def outline(self) -> tuple[float, float, float, float, float]:
        """Outline on the floor: x, y in the world in [m], yaw in [rad], length and width in [m]."""
        pose, (length, width, _) = self.box.pose, self.box.size
        return float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0]), length, width

    @property
    def material(self) -> Material:
        """Material of the solid's sides in colour pictures."""
        if self.box.name.startswith("wall"):
            return PLASTER_MATERIAL
        return WOOD_MATERIAL if " of " in self.box.name else LACQUER_MATERIAL

    def reaches(self, height: float) -> bool:
        """Return whether the solid intersects the level plane at a height, in [m]."""
        return abs(float(self.box.pose[2, 3]) - height) <= self.box.size[2] / 2


THE_GROUND = Solid(Box(Pose2(0.0, 0.0, 0.0).lift(-0.5), (_WIDE, _WIDE, 1.0), "the ground"))
"""Outdoors: its top is at height 0."""


def room_of(world: WorldFile) -> list[Solid]:
    """Return the walls, furniture, tables and surprises (obstacles that no map shows) of a world.

    The ground and the solids of application domains are not included.
    """
    solids = [of_wall(wall, number) for number, wall in enumerate(world.walls)]
    solids += [of_furniture(piece) for piece in (*world.furniture, *world.surprises)]
    return solids + [part for table in world.tables for part in of_table(table)]


def of_wall(wall: Wall, index: int) -> Solid:
    """Return a wall as a solid, half its thickness longer at both ends.

    Args:
        wall: section of the world's file.
        index: index of the wall in that file, from 0, which gives its name.
    """
    (ax, ay), (bx, by) = wall.from_m, wall.to_m
    pose = Pose2((ax + bx) / 2, (ay + by) / 2, math.atan2(by - ay, bx - ax)).lift(WALL_HEIGHT / 2)
    length = math.hypot(bx - ax, by - ay) + wall.thickness_m
    return Solid(Box(pose, (length, wall.thickness_m, WALL_HEIGHT), f"wall {index + 1}"))


def of_furniture(piece: Furniture) -> Solid:
    """Return a piece of furniture as a solid; a surprise (obstacle that is not on the robot's map) keeps the
    times at which it appears and disappears.
    """
    middle = piece.above_m + piece.size_m[2] / 2
    pose = Pose2(piece.x_m, piece.y_m, math.radians(piece.heading_deg)).lift(middle)
    box = Box(pose, piece.size_m, piece.name)
    if not isinstance(piece, Surprise):
        return Solid(box)
    leaves = _FOREVER if piece.leaves_s is None else piece.leaves_s
    return Solid(box, piece.appears_s or 0.0, leaves)


def of_table(table: TableSpec) -> tuple[Solid, Solid]:
    """Return a table as two solids, its pedestal and its slab."""
    pose = Pose2(table.x_m, table.y_m, math.radians(table.heading_deg))
    length, width, top = table.size_m
    under = top - table.slab_m
    foot = Box(pose.lift(under / 2), (*table.foot_m, under), f"foot of {table.name}")
    slab = Box(pose.lift(top - table.slab_m / 2), (length, width, table.slab_m), table.name)
    return Solid(foot), Solid(slab)


class FloorPlan:
    """Floor plan with the outlines, as arrays, of the solids that reach into a range of heights."""

    def __init__(self, solids: Sequence[Solid], low: float, high: float) -> None:
        """Keep the solids that reach into the range between the heights `low` and `high`, in [m]."""
        chosen = [
            solid
            for solid in solids
            if solid.box.pose[2, 3] - solid.box.size[2] / 2 < high
            and solid.box.pose[2, 3] + solid.box.size[2] / 2 > low
        ]
        self.names = tuple(solid.box.name for solid in chosen)
        poses = np.array([solid.box.pose for solid in chosen]).reshape(-1, 4, 4)
        self.middle: FloatArray = poses[:, :2, 3]
        self.cos, self.sin = poses[:, 0, 0], poses[:, 1, 0]
        self.headings: FloatArray = np.arctan2(self.sin, self.cos)
        self.half = np.array([solid.box.size[:2] for solid in chosen]).reshape(-1, 2) / 2
        self._appears = np.array([solid.appears for solid in chosen])
        self._leaves = np.array([solid.leaves for solid in chosen])
        self.steady = bool(np.all((self._appears == 0.0) & np.isinf(self._leaves)))

    def there(self, time: float) -> BoolArray:
        """Return a mask (n,), True for the solids that are present at a time in [s]."""
        present: BoolArray = (self._appears <= time) & (time < self._leaves)
        return present

    def local(self, x: float, y: float) -> FloatArray:
        """Return a point's coordinates (n, 2) in the frames of all n outlines, in [m].

        Args:
            x: in the world, in [m].
            y: in the world, in [m].
        """
        dx, dy = x - self.middle[:, 0], y - self.middle[:, 1]
        return np.column_stack((self.cos * dx + self.sin * dy, self.cos * dy - self.sin * dx))

    def gap(self, base: Pose2, footprint: Footprint, time: float) -> tuple[float, str]:
        """Return the distance of a footprint to the nearest solid that is in the world at a time, in [m], and
        the solid's name.

        A negative distance means that they overlap; it is infinite if no solid is there.
        """
        if footprint.is_disc:
            away, name = self.clearance(base.x, base.y, time)
            return away - footprint.radius, name
        if not self.names:
            return math.inf, ""
        distance = self._distances(base.x, base.y)
        if not self.steady:
            distance = np.where(self.there(time), distance, np.inf)
            if not np.isfinite(distance).any():
                return math.inf, ""
        corners = np.ascontiguousarray(base.apply(footprint.corners))
        # no other outline can be nearer than the one with the nearest middle of the base at most is
        candidates = np.flatnonzero(distance - footprint.radius <= distance.min() - footprint.inscribed)
        gaps = [polygon_gap(corners, self._corners[i]) for i in candidates]
        nearest = int(np.argmin(gaps))
        return gaps[nearest], self.names[candidates[nearest]]

    @cached_property
    def _corners(self) -> FloatArray:
        """Return the corners (n, 4, 2) of all outlines in the world, counter-clockwise, in [m]."""
        along = self.half[:, None] * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
        x = self.middle[:, None, 0] + self.cos[:, None] * along[..., 0] - self.sin[:, None] * along[..., 1]
        y = self.middle[:, None, 1] + self.sin[:, None] * along[..., 0] + self.cos[:, None] * along[..., 1]
        return np.ascontiguousarray(np.stack([x, y], axis=-1))

    def _distances(self, x: float, y: float) -> FloatArray:
        """Return the signed distances (n,) of a point x, y in the world to all outlines, in [m]; below 0
        inside.
        """
        out_x, out_y = (np.abs(self.local(x, y)) - self.half).T
        distance = np.hypot(np.maximum(out_x, 0.0), np.maximum(out_y, 0.0))
        return np.asarray(distance + np.minimum(np.maximum(out_x, out_y), 0.0))

    def clearance(self, x: float, y: float, time: float) -> tuple[float, str]:
        """Return the distance of a point to the nearest present outline in [m], and the solid's name.

        Below 0 the point is inside; infinity if no outline is present.

        Args:
            x: in the world, in [m].
            y: in the world, in [m].
            time: simulated time, in [s].
        """
        if not self.names:
            return math.inf, ""
        distance = self._distances(x, y)
        if not self.steady:
            distance = np.where(self.there(time), distance, np.inf)
        nearest = int(np.argmin(distance))
        return float(distance[nearest]), self.names[nearest]
