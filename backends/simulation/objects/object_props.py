"""The objects of a simulated world."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.props import Props

from .carried_object import CarriedObject
from .spec import ObjectsSection


class ObjectProps(Props[ObjectsSection]):
    """Objects by their names in the world's file: a person sets them down, hands carry them."""

    section = ObjectsSection
    STATE: ClassVar[Kinds] = {"objects": dict[str, CarriedObject]}

    @override
    def set_up(self) -> None:
        self.objects = {
            spec.name: CarriedObject.set_down(self.scene, spec, self.seed) for spec in self.spec.objects
        }

    @override
    def things(self) -> Iterable[CarriedObject]:
        return self.objects.values()
