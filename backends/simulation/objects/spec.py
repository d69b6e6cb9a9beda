"""Objects in a world's file."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.backends.description.things.printed_tag import PrintedTag
from handcart.backends.simulation.world.placed_thing import PlacedSpec
from handcart.backends.simulation.world.world_file import FloorPose, Length, Name, each_once
from handcart.files.models.model import FileModel
from handcart.robotics.geometry.pose2 import Pose2

from .pull_spec import PullSpec

MAX_PULLS = 100


class CarriedObjectSpec(PlacedSpec):
    """Box or cylinder that a person sets down; its pose is that of the middle of its underside."""

    shape: Literal["box", "cylinder"] = "box"
    """A cylinder is upright; along its x and y it has one size, its diameter."""
    mass_kg: Annotated[float, Field(gt=0.0, le=50.0)] = 0.3
    friction: Annotated[float, Field(gt=0.0, le=2.0)] = 0.65
    """Friction coefficient of the object; its product with that of the touched body counts."""
    tags: tuple[PrintedTag, ...] = ()
    """Tags printed on its sides."""
    sigma_mm: Annotated[float, Field(ge=0.0, le=1000.0)] = 0.0
    """Standard deviation, along each axis, of where the person sets it down."""
    sigma_deg: Annotated[float, Field(ge=0.0, le=180.0)] = 0.0
    """Standard deviation of its heading then."""

    @model_validator(mode="after")
    def _is_round(self) -> Self:
        if self.shape == "cylinder" and self.size_mm[0] != self.size_mm[1]:
            x, y, _ = self.size_mm
            wrong = f"a cylinder has one diameter, not {x:g} and {y:g} mm"
            raise ValueError(f"{wrong}; allowed: the same size along x and y")
        return self

    @model_validator(mode="after")
    def _tags_fit(self) -> Self:
        for tag in self.tags:
            if not tag.fits(self.size_mm, self.shape == "cylinder"):
                raise ValueError(f"the tag {tag.id} is larger than the side {tag.face}; allowed: within it")
        return self


class FloorAreaSpec(FloorPose):
    """Rectangle of the floor where objects may be put down; elsewhere on the floor they count as fallen.

    The pose of the area is that of its middle.
    """

    name: Name
    size_m: tuple[Length, Length]
    """Lengths along the area's own x and y."""

    def carries(self, x: float, y: float) -> bool:
        """Return whether a point x, y of the floor in the world, in [m], is in the area."""
        off = Pose2(x, y, 0.0).relative_to(Pose2(self.x_m, self.y_m, math.radians(self.heading_deg)))
        return abs(off.x) <= self.size_m[0] / 2 and abs(off.y) <= self.size_m[1] / 2


class ObjectsSection(FileModel):
    """Section of a world's file with objects to carry, floor areas for them, and pulls of a person at the
    hand.
    """

    objects: tuple[CarriedObjectSpec, ...] = ()
    floor_areas: tuple[FloorAreaSpec, ...] = ()
    """Areas of the floor that objects are on, or may be put down on."""
    pulls: Annotated[tuple[PullSpec, ...], Field(max_length=MAX_PULLS)] = ()
    """A person's pulls at what the hand holds."""

    @model_validator(mode="after")
    def _each_object_once(self) -> Self:
        each_once("object", (object_.name for object_ in self.objects))
        each_once("floor area", (area.name for area in self.floor_areas))
        return self

    @model_validator(mode="after")
    def _on_areas(self) -> Self:
        """Refuse objects on the floor beside the areas that a file has for them."""
        for item in self.objects if self.floor_areas else ():
            is_low = item.on == "world" and item.height_m <= 0.0
            if is_low and not any(area.carries(item.x_m, item.y_m) for area in self.floor_areas):
                wrong = f"the object {item.name!r} is on the floor outside of every floor area: it has fallen"
                names = ", ".join(area.name for area in self.floor_areas)
                raise ValueError(f"{wrong}; allowed: a place within {names}, or a height_m above 0")
        return self
