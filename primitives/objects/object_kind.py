"""Kinds of objects, and single objects, in a file of objects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from handcart.backends.description.printed_tag import Face, PrintedTag
from handcart.files.models.model import FileModel
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

Positive = Annotated[float, Field(gt=0.0)]
Millimetres = Annotated[float, Field(gt=0.0, le=2000.0)]
Name = Annotated[str, Field(min_length=1, max_length=60)]
HALF_TURN_DEG = 180.0


class ObjectKind(FileModel):
    """A kind of objects: boxes of one size. Its frame: origin in the middle of the foot, z up."""

    shape: Literal["box"] = "box"
    size_mm: tuple[Millimetres, Millimetres, Millimetres]
    """Along its x, y and z (upwards)."""
    mass_kg: Positive | None = None
    """If given, the lifted object is weighed."""
    tags: tuple[PrintedTag, ...] = ()
    """Tags on all objects of this kind; tags of a single object are under `objects:`."""
    grasps: Literal["any"] | Annotated[tuple[Face, ...], Field(min_length=1)] = "any"
    """Sides that the hand may come from."""
    upright: bool = True
    """True if it has to stay upright while it is carried."""

    @property
    def size(self) -> tuple[float, float, float]:
        """Along x, y and z, in [m]."""
        x, y, z = (each / 1e3 for each in self.size_mm)
        return x, y, z

    def body(self, name: str) -> Box:
        """Return its box in its own frame."""
        return Box(transform((0.0, 0.0, self.size[2] / 2)), self.size, name)


class KnownObject(FileModel):
    """An object, and where it is believed to be."""

    kind: Name
    on: Name
    """ObjectSurface that it stands on."""
    x_m: float | None = None
    """On the map (default: anywhere on the surface)."""
    y_m: float | None = None
    heading_deg: float = 0.0
    sigma_mm: Annotated[float, Field(ge=0.0, le=2000.0)] = 40.0
    """Standard deviation of its place, along each axis."""
    sigma_deg: Annotated[float, Field(ge=0.0, le=HALF_TURN_DEG)] = 30.0
    """Standard deviation of its heading."""
    tags: tuple[PrintedTag, ...] = ()
    """Its tags, in addition to those of its kind."""
