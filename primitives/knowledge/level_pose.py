"""Poses on level surfaces, as files state them."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Box


class LevelPose(FileModel):
    """A pose on a level surface.

    It is given on the map, or in the base frame for the table that the robot itself carries.
    """

    x_m: float
    y_m: float
    height_m: Annotated[float, Field(ge=0.0, le=3.0)]
    """Height of the surface."""
    heading_deg: float = 0.0

    @property
    def floor(self) -> Pose2:
        """x, y and heading, without the height, in the frame in which the pose is given."""
        return Pose2(self.x_m, self.y_m, math.radians(self.heading_deg))

    @property
    def pose(self) -> Transform:
        """This pose (4, 4) with the surface's height as z, in the frame (map or base) of `x_m` and `y_m`."""
        return self.floor.lift(self.height_m)

    def body(self, size: tuple[float, float, float], name: str) -> Box:
        """Return a box called `name` that rests on the level surface at this pose, in the frame in which the
        pose is given; `size` is along the box's x, y and z, in [m].
        """
        return Box(self.floor.lift(self.height_m + size[2] / 2), size, name)
