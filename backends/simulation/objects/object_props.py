"""The objects of a simulated world."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import ClassVar

from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.solids import Solid
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import Box

from .carried_object import CarriedObject
from .spec import ObjectsSection

FLOOR_DEPTH_M = 0.05
FLOOR_GREY = 95  # as the floor around it


class ObjectProps(Props[ObjectsSection]):
    """Objects by their names in the world's file: a person sets them down, hands carry them."""

    section = ObjectsSection
    STATE: ClassVar[Kinds] = {"objects": dict[str, CarriedObject]}

    @override
    @classmethod
    def solids(cls, spec: ObjectsSection) -> Sequence[Solid]:
        """Return the areas of the floor that carry objects, as slabs whose top is at height 0."""
        slabs = []
        for area in spec.floor_areas:
            pose = Pose2(area.x_m, area.y_m, math.radians(area.heading_deg)).lift(-FLOOR_DEPTH_M / 2)
            slabs.append(Solid(Box(pose, (*area.size_m, FLOOR_DEPTH_M), area.name), grey=FLOOR_GREY))
        return slabs

    @override
    def set_up(self) -> None:
        self.objects = {
            spec.name: CarriedObject.set_down(self.scene, spec, self.seed) for spec in self.spec.objects
        }

    @override
    def things(self) -> Iterable[CarriedObject]:
        return self.objects.values()
