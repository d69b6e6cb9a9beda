"""Kinds of objects, and single objects, in a file of objects."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.backends.description.things.printed_tag import Face, PrintedTag
from handcart.files.models.model import FileModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box, Cylinder, Solid
from handcart.robotics.manipulation.grasping.box_grasps import Grasp, box_grasps
from handcart.robotics.manipulation.grasping.cylinder_grasps import cylinder_grasps

Positive = Annotated[float, Field(gt=0.0)]
Millimetres = Annotated[float, Field(gt=0.0, le=2000.0)]
Name = Annotated[str, Field(min_length=1, max_length=60)]
HALF_TURN_DEG = 180.0


class ObjectKind(FileModel):
    """A kind of objects of one shape and size.

    The frame of an object has its origin in the middle of the object's foot, and z up.
    """

    shape: Literal["box", "cylinder"] = "box"
    """A cylinder is upright; along its x and y it has one size, its diameter."""
    size_mm: tuple[Millimetres, Millimetres, Millimetres]
    """Size along the object's x, y and z (upwards)."""
    mass_kg: Positive | None = None
    """Mass of an object; if given, the lifted object is weighed."""
    tags: tuple[PrintedTag, ...] = ()
    """Tags on all objects of this kind; tags of a single object are under `objects:`."""
    grasps: Literal["any"] | Annotated[tuple[Face, ...], Field(min_length=1)] = "any"
    """Sides that the hand may come from; on a cylinder any but `+z` means all around it."""
    upright: bool = True
    """True if it has to stay upright while it is carried."""

    @property
    def size(self) -> tuple[float, float, float]:
        """Size of an object of this kind along x, y and z, in [m]."""
        x, y, z = (item / 1e3 for item in self.size_mm)
        return x, y, z

    @model_validator(mode="after")
    def _has_one_diameter(self) -> Self:
        if self.is_round and self.size_mm[0] != self.size_mm[1]:
            x, y, _ = self.size_mm
            wrong = f"a cylinder has one diameter, not {x:g} and {y:g} mm"
            raise ValueError(f"{wrong}; allowed: the same size along x and y")
        return self

    @property
    def is_round(self) -> bool:
        """True if objects of this kind are cylinders."""
        return self.shape == "cylinder"

    @property
    def foot_radius(self) -> float:
        """Radius of the smallest circle around the footprint of an upright object, in [m]."""
        return self.size[0] / 2 if self.is_round else math.hypot(*self.size[:2]) / 2

    def foot_distance(self, point: Pose2) -> float:
        """Return the distance from an upright object's footprint to a point, in [m]; 0 inside.

        Args:
            point: the point, in the object's frame.
        """
        if self.is_round:
            return max(0.0, math.hypot(point.x, point.y) - self.size[0] / 2)
        beyond = (max(0.0, abs(point.x) - self.size[0] / 2), max(0.0, abs(point.y) - self.size[1] / 2))
        return math.hypot(*beyond)

    def grasps_within(self, opening: float, tip: float, base_T_object: Transform) -> Iterator[Grasp]:
        """Yield the grasps that this kind allows, the best ones first.

        Args:
            opening: largest opening of the fingers, in [m].
            tip: distance from the frame `hand` to the finger tips, in [m].
            base_T_object: (4, 4) pose of the object; round objects are gripped from the base's side first.
        """
        faces = None if self.grasps == "any" else self.grasps
        if not self.is_round:
            return box_grasps(self.size, opening, tip, faces)
        x, y, _ = inverse(base_T_object)[:3, 3].tolist()
        above, around = (faces is None or "+z" in faces), (faces is None or set(faces) != {"+z"})
        return cylinder_grasps(self.size[0], self.size[2], opening, tip, math.atan2(y, x), above, around)

    def body(self, name: str) -> Solid:
        """Return the shape of an object of this kind, posed in the object's frame and named `name`."""
        middle = transform((0.0, 0.0, self.size[2] / 2))
        if self.is_round:
            return Cylinder(middle, self.size[0] / 2, self.size[2], name)
        return Box(middle, self.size, name)


class KnownObject(FileModel):
    """Object in a file of objects, with its kind, tags, surface and expected pose on this surface."""

    kind: Name
    on: Name
    """Name of the surface that the object is on."""
    x_m: float | None = None
    """Believed x on the map (default: anywhere on the surface)."""
    y_m: float | None = None
    heading_deg: float = 0.0
    sigma_mm: Annotated[float, Field(ge=0.0, le=2000.0)] = 40.0
    """Standard deviation of the believed position, along each axis."""
    sigma_deg: Annotated[float, Field(ge=0.0, le=HALF_TURN_DEG)] = 30.0
    """Standard deviation of the believed heading."""
    tags: tuple[PrintedTag, ...] = ()
    """Its tags, in addition to those of its kind."""
