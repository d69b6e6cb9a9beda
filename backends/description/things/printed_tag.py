"""A square tag on a side of a box, in files."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from handcart.files.models.model import FileModel
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.perception.landmarks.tag_family import TagFamily, tags_of

Face = Literal["-x", "+x", "-y", "+y", "-z", "+z"]
FACE_TURNS: dict[Face, tuple[float, float, float]] = {
    "+z": (0.0, 0.0, 0.0),
    "-z": (math.pi, 0.0, 0.0),
    "+x": (math.pi / 2, 0.0, math.pi / 2),
    "-x": (math.pi / 2, 0.0, -math.pi / 2),
    "+y": (math.pi / 2, 0.0, math.pi),
    "-y": (math.pi / 2, 0.0, 0.0),
}
"""Roll, pitch and yaw of each side's frame in [rad]: seen from outside, x right and y up; z points out."""
FACE_AXES: dict[str, tuple[int, int]] = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}
"""Numbers (0 to 2) of the box's axes along x and y of a side's frame, by the axis of its normal."""
UNIT_TAG_CORNERS = np.array([[-0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [-0.5, -0.5, 0.0]])
"""Corners (4, 3) of a tag of side 1 in the tag's frame, clockwise from the tag's own upper left."""


class PrintedTag(FileModel):
    """Family, number, size and place of a tag that is printed on a side of a box."""

    family: TagFamily = "apriltag_36h11"
    id: Annotated[int, Field(ge=0)]
    side_mm: Annotated[float, Field(gt=0.0, le=500.0)]
    """Side of the tag's black square."""
    face: Face = "+z"
    """Side of the box, by its outward normal; `+z` is the upper one."""
    x_mm: float = 0.0
    """Offset of the tag's middle from the middle of the side, to the right, as seen from outside."""
    y_mm: float = 0.0
    """Offset of the tag's middle from the middle of the side, upwards; on `+z` along the box's y."""
    turn_deg: float = 0.0
    """Counter-clockwise turn on the side, as seen from outside."""

    @model_validator(mode="after")
    def _in_family(self) -> Self:
        if self.id >= tags_of(self.family):
            raise ValueError(f"{self.family} has no tag {self.id}; allowed: 0 to {tags_of(self.family) - 1}")
        return self

    @property
    def key(self) -> tuple[TagFamily, int]:
        """Family and number, as a tag detector returns them."""
        return self.family, self.id

    @property
    def side(self) -> float:
        """Side of the tag's black square, in [m]."""
        return self.side_mm / 1e3

    def fits(self, size_mm: tuple[float, float, float], is_round: bool = False) -> bool:
        """Return True if the tag lies within the side of the box on which it is printed.

        On a cylinder the tag must lie within the largest square on the top or the underside, because on the
        curved side it would be bent.

        Args:
            size_mm: size of the box (or of the cylinder's bounding box) along its x, y and z, in [mm].
            is_round: True for a cylinder about the z axis.
        """
        if is_round:
            within = size_mm[0] * math.sqrt(0.5)
            return self.face[1] == "z" and self.fits((within, within, size_mm[2]))
        turn = math.radians(self.turn_deg)
        half = 0.5 * self.side_mm * (abs(math.cos(turn)) + abs(math.sin(turn)))
        along, up = FACE_AXES[self.face[1]]
        return abs(self.x_mm) + half <= size_mm[along] / 2 and abs(self.y_mm) + half <= size_mm[up] / 2

    def on_box(self, size: tuple[float, float, float]) -> Transform:
        """Return the pose of the tag in the box frame, box_T_tag (4, 4).

        Box frame: origin in the middle of the box's underside, axes along its sides. Tag frame: origin in the
        tag's middle, x right, y up, z out of the box.

        Args:
            size: size of the box along its x, y and z, in [m].
        """
        out = np.zeros(3)
        axis = "xyz".index(self.face[1])
        out[axis] = math.copysign(size[axis] / 2, float(self.face[0] + "1"))
        out[2] += size[2] / 2
        on_face = transform((self.x_mm / 1e3, self.y_mm / 1e3, 0.0), (0.0, 0.0, math.radians(self.turn_deg)))
        return np.asarray(transform(out.tolist(), FACE_TURNS[self.face]) @ on_face)
