"""Work piece of a seam: boxes on the map."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import Box

Positive = Annotated[float, Field(gt=0.0, le=100.0)]


class WorkBox(FileModel):
    """Box of a work piece; the stated pose is that of the middle of its underside."""

    name: str
    x_m: float
    y_m: float
    heading_deg: float = 0.0
    above_m: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """Height of its underside above the floor."""
    size_m: tuple[Positive, Positive, Positive]
    """Size along its own x and y, and its height."""

    @property
    def box(self) -> Box:
        """Return this part of the work piece as a box, posed on the map."""
        floor = Pose2(self.x_m, self.y_m, math.radians(self.heading_deg))
        return Box(floor.lift(self.above_m + self.size_m[2] / 2), self.size_m, self.name)


class WorkPiece(FileModel):
    """Work piece to be welded, described by its own boxes and those of the things that it lies on."""

    format: Literal["handcart-work-piece/1"]
    boxes: Annotated[tuple[WorkBox, ...], Field(min_length=1)]
