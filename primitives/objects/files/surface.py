"""Surfaces that carry objects, in a file of objects."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.navigation.maps.movable_areas import MovableArea
from handcart.robotics.numerics.arrays import FloatArray

Positive = Annotated[float, Field(gt=0.0)]
Name = Annotated[str, Field(min_length=1, max_length=60)]
PLACED_SIGMA_M, PLACED_SIGMA_RAD = 0.05, math.radians(4.0)  # of a surface from its pose in the file
MAX_SIGMAS_MOVED = 3.0  # of it, by which a surface may be elsewhere
WALL_M = 0.02  # thickness of walls at its sides
FLOOR_M = 0.05  # thickness of what is below an area of the floor
FLOOR_NAMES = ("floor", "the ground")
"""Names of the floor in contacts."""
WALL_SIDES: dict[str, tuple[int, int]] = {"+x": (0, 1), "-x": (0, -1), "+y": (1, 1), "-y": (1, -1)}
"""Axis and sign of each side of a surface, in its own frame."""


class SurfaceSpot(FileModel):
    """Named spot of a surface where an object may be placed, as a pose on the map."""

    x_m: float
    y_m: float
    heading_deg: float | None = None
    """Heading of what is put there (default: any)."""

    @property
    def pose(self) -> Pose2:
        """Pose on the map of this spot (place for an object on a surface); the heading is 0 if the spot
        allows any heading.
        """
        return Pose2(self.x_m, self.y_m, math.radians(self.heading_deg or 0.0))

    def moved_by(self, before: Pose2, now: Pose2) -> Self:
        """Return this spot, where objects may be placed, after the surface that it is on was moved.

        Args:
            before: earlier pose of the surface, on the map.
            now: present pose of the surface, on the map.
        """
        pose = now.compose(self.pose.relative_to(before))
        heading = None if self.heading_deg is None else math.degrees(pose.theta)
        return self.model_copy(update={"x_m": pose.x, "y_m": pose.y, "heading_deg": heading})


class ObjectSurface(LevelPose):
    """A level surface that carries objects, such as a table, a shelf's board or an area of the floor.

    Its pose is that of the middle of its top, on the map.
    """

    size_m: tuple[Positive, Positive]
    """Size of the top along its own x and y."""
    clearance_m: Positive | None = None
    """Free height above it, up to the next board (default: open)."""
    ceiling_m: Positive = 0.04
    """Thickness of that board."""
    thickness_m: Positive | None = None
    """Thickness of the body below the top, as of a board (default: solid down to the floor)."""
    walls: tuple[Literal["+x", "-x", "+y", "-y"], ...] = ()
    """Its own sides with a wall: those of a shelf or a box."""
    wall_m: Positive | None = None
    """Height of these walls above it (default: `clearance_m`)."""
    kinds: Literal["any"] | tuple[Name, ...] = "any"
    """Kinds of objects that may be there."""
    spots: Mapping[Name, SurfaceSpot] = Field(default_factory=dict)
    place: Name | None = None
    """Place of the base for work on it (default: computed)."""
    fixed: bool = False
    """Whether it is built in and cannot have moved (default: it may have, and localizers do not use it)."""

    @model_validator(mode="after")
    def _walls_have_a_height(self) -> Self:
        if self.walls and self.wall_m is None and self.clearance_m is None:
            raise ValueError("walls without a height; allowed: wall_m, or clearance_m")
        return self

    def boxes(self, name: str, room: float = 0.0) -> tuple[Box, ...]:
        """Return the bodies that the arm must not touch: the surface, its walls, and the board above it.

        Args:
            name: name of the bodies.
            room: distance by which a wall's inner and outer face are moved outwards, in [m].
        """
        result = []
        length, width = self.size_m
        thick = min(self.height_m, self.thickness_m or self.height_m) if self.height_m > 0.0 else FLOOR_M
        middle = self.pose @ transform((0.0, 0.0, -thick / 2))
        result.append(Box(middle, (length, width, thick), name))
        if self.clearance_m is not None:
            above = self.pose @ transform((0.0, 0.0, self.clearance_m + self.ceiling_m / 2))
            result.append(Box(above, (length, width, self.ceiling_m), name))
        return (*result, *self._walls(name, room))

    def _walls(self, name: str, room: float) -> Iterator[Box]:
        """Yield the walls, outside of its extent: from the floor up to their height, or to what is above."""
        top = self.wall_m or (self.clearance_m or 0.0) + self.ceiling_m
        thick = WALL_M + 2.0 * room
        for side in self.walls:
            axis, sign = WALL_SIDES[side]
            off = sign * (self.size_m[axis] + WALL_M) / 2
            middle, high = (top - self.height_m) / 2, top + self.height_m
            if axis == 0:  # closes the corners
                low, up = (WALL_M if beside in self.walls else 0.0 for beside in ("-y", "+y"))
                place = self.pose @ transform((off, (up - low) / 2, middle))
                yield Box(place, (thick, self.size_m[1] + low + up, high), name)
            else:
                yield Box(self.pose @ transform((0.0, off, middle)), (self.size_m[0], thick, high), name)

    def contact_names(self, name: str) -> tuple[str, ...]:
        """Return the names, in simulated worlds, of the bodies on which an object on this surface may rest.

        Args:
            name: name of the surface.
        """
        return (name, *FLOOR_NAMES) if self.height_m <= 0.0 else (name,)

    @property
    def _half(self) -> FloatArray:
        """Half of the surface's extent (2,) with its walls, in [m]."""
        return np.array(self.size_m) / 2 + (WALL_M if self.walls else 0.0)

    @property
    def outline(self) -> FloatArray:
        """Corners (4, 2) on the map of a rectangle around the surface and its own side walls, in [m].

        They are in counter-clockwise order.
        """
        return self.floor.apply(np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * self._half)

    def movable_area(self) -> MovableArea | None:
        """Return the area of the map in which the surface may be, because it may have been moved.

        The result is None for a surface that cannot move: an area of the floor without walls, or a surface
        marked as fixed.
        """
        if self.fixed or (self.height_m <= 0.0 and not self.walls):
            return None
        by_turn = float(np.hypot(*self._half)) * math.sin(MAX_SIGMAS_MOVED * PLACED_SIGMA_RAD)
        margin = math.hypot(MAX_SIGMAS_MOVED * PLACED_SIGMA_M, by_turn)
        return MovableArea(
            self.outline, margin, high=self.height_m + (self.wall_m or self.clearance_m or 0.0)
        )

    def margin(self, x: float, y: float) -> float:
        """Return the distance of a point from the surface's edge, in [m]; positive inside, negative outside.

        Args:
            x: x of the point on the map, in [m].
            y: y of the point on the map, in [m].
        """
        off = Pose2(x, y, 0.0).relative_to(self.floor)
        return min(self.size_m[0] / 2 - abs(off.x), self.size_m[1] / 2 - abs(off.y))

    def moved_to(self, pose: Pose2) -> Self:
        """Return the surface at another pose on the map; its spots (places for objects) move with it."""
        spots = {name: spot.moved_by(self.floor, pose) for name, spot in self.spots.items()}
        heading = math.degrees(pose.theta)
        return self.model_copy(update={"x_m": pose.x, "y_m": pose.y, "heading_deg": heading, "spots": spots})

    def allows(self, kind: str) -> bool:
        """Return whether objects of a kind may be on this surface."""
        return self.kinds == "any" or kind in self.kinds
