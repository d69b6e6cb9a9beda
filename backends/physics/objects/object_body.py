"""An object as a body."""

from __future__ import annotations

from typing import cast

from typing_extensions import override

from handcart.backends.physics.world.thing_body import ThingBody
from handcart.backends.simulation.objects.carried_object import CarriedObject


class ObjectBody(ThingBody):
    """Body of a carried object in a physics engine, with the coefficient of friction in the world's file."""

    @override
    def friction(self) -> float:
        return cast(CarriedObject, self.thing).spec.friction
