"""Front and handle of a simulated door."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.description.things.printed_tag import PrintedTag
from handcart.backends.simulation.objects.printed_thing import PrintedThing
from handcart.backends.simulation.objects.tag_print import printed_faces
from handcart.backends.simulation.world.thing import GreyImage, Rest, Side
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.numerics.arrays import FloatArray

from .spec import SimulatedDoorSpec

FRONT, HANDLE = "door", "handle"


@dataclass(eq=False, repr=False)
class DoorPart(PrintedThing):
    """The front or the handle of a simulated door or drawer, which only moves along the door's joint."""

    FREE: ClassVar[bool] = False

    spec: SimulatedDoorSpec
    part: str
    """`FRONT` or `HANDLE`."""

    @property
    @override
    def name(self) -> str:
        return f"{self.part} {self.spec.name}"

    @property
    def is_handle(self) -> bool:
        """True if this part is the handle of the door, False for its front."""
        return self.part == HANDLE

    @property
    def size(self) -> tuple[float, float, float]:
        """Lengths along x, y, z of the part's frame, in [m].

        They are thickness, width and height of a front, or diameter, diameter and length of a handle.
        """
        handle = self.spec.handle
        if self.is_handle:
            return handle.width, handle.width, handle.length_mm / 1e3
        return self.spec.front(self.spec.true_joint())[1]

    @property
    @override
    def is_round(self) -> bool:
        return self.is_handle

    @property
    @override
    def mass(self) -> float:
        """Mass that the hand carries, in [kg], which is 0 because the door's joint carries the part."""
        return 0.0

    @property
    @override
    def grey(self) -> int:
        return self.spec.grey if not self.is_handle else max(0, self.spec.grey - 90)

    @override
    def draw_faces(self) -> Mapping[Side, GreyImage]:
        if self.is_handle or not self.spec.tags:
            return {}
        aside = self.spec.front(self.spec.true_joint())[0][1, 3]
        printed = [
            PrintedTag(
                family=tag.family,
                id=tag.id,
                side_mm=tag.side_mm,
                face="+x",
                x_mm=tag.right_mm - 1e3 * aside,
                y_mm=tag.up_mm,
            )
            for tag in self.spec.tags
        ]
        size = (1e3 * self.size[0], 1e3 * self.size[1], 1e3 * self.size[2])
        return printed_faces(printed, size, self.spec.grey)


def handle_T_part(spec: SimulatedDoorSpec, part: str) -> Transform:
    """Return the pose handle_T_part (4, 4) of a part of a door in the frame of its handle.

    The handle's frame has its origin in the middle of the handle's bar, x away from the closed door, z up.
    The part is `FRONT` or `HANDLE`; the origin of the part's frame is in the middle of the part's lower end.
    """
    if part == FRONT:
        return np.asarray(spec.front(spec.true_joint())[0] @ transform((0.0, 0.0, -spec.height_mm / 2e3)))
    half = spec.handle.length_mm / 2e3
    if spec.handle.bar == "vertical":
        return transform((0.0, 0.0, -half))
    return transform((0.0, half, 0.0), (math.pi / 2, 0.0, 0.0))


def part_at(spec: SimulatedDoorSpec, part: str, opening: float) -> Transform:
    """Return the pose world_T_part (4, 4) of a door's part at an opening in [rad], or in [m] for a drawer.

    The origin of the part's frame is in the middle of its lower end.
    """
    return np.asarray(spec.true_joint().handle_at(opening) @ handle_T_part(spec, part))


def new_part(spec: SimulatedDoorSpec, part: str, opening: float) -> DoorPart:
    """Create the simulated front or handle of a door, posed at an opening.

    Args:
        spec: the door.
        part: `FRONT` or `HANDLE`.
        opening: opening in [rad], or of a drawer in [m].
    """
    return DoorPart(part_at(spec, part, opening), Rest.TABLE, spec, part)


def middle_of(part: DoorPart) -> FloatArray:
    """Return the middle (3,) of a door's front or handle in the world, in [m]."""
    return np.asarray((part.pose @ part.thing_T_middle)[:3, 3])
