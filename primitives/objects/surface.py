"""Surfaces that carry objects, in a file of objects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

Positive = Annotated[float, Field(gt=0.0)]
Name = Annotated[str, Field(min_length=1, max_length=60)]
CEILING_M = 0.04  # thickness of what is above a surface with a clearance


class SurfaceSpot(FileModel):
    """A named spot on a surface, on the map."""

    x_m: float
    y_m: float
    heading_deg: float | None = None
    """Heading of what is put there (default: any)."""

    @property
    def pose(self) -> Pose2:
        """Pose on the map; heading 0 where any will do."""
        return Pose2(self.x_m, self.y_m, math.radians(self.heading_deg or 0.0))


class ObjectSurface(LevelPose):
    """A level surface that carries objects: a table, a shelf's board, an area of the floor.

    Its pose is that of the middle of its top, on the map.
    """

    size_m: tuple[Positive, Positive]
    """Along its own x and y."""
    clearance_m: Positive | None = None
    """Free height above it, up to the next board (default: open)."""
    kinds: Literal["any"] | tuple[Name, ...] = "any"
    """Kinds of objects that may be there."""
    spots: Mapping[Name, SurfaceSpot] = Field(default_factory=dict)
    place: Name | None = None
    """Place of the base for work on it (default: computed)."""

    def boxes(self, name: str) -> tuple[Box, ...]:
        """Return what the arm must not touch: its body down to the floor, and what is above it."""
        result = []
        length, width = self.size_m
        if self.height_m > 0.0:
            middle = self.pose @ transform((0.0, 0.0, -self.height_m / 2))
            result.append(Box(middle, (length, width, self.height_m), name))
        if self.clearance_m is not None:
            above = self.pose @ transform((0.0, 0.0, self.clearance_m + CEILING_M / 2))
            result.append(Box(above, (length, width, CEILING_M), name))
        return tuple(result)

    def margin(self, x: float, y: float) -> float:
        """Return how far a point of the map is inside of its edge, in [m]; negative outside."""
        off = Pose2(x, y, 0.0).relative_to(self.floor)
        return min(self.size_m[0] / 2 - abs(off.x), self.size_m[1] / 2 - abs(off.y))

    def allows(self, kind: str) -> bool:
        """Return whether objects of a kind may be there."""
        return self.kinds == "any" or kind in self.kinds
