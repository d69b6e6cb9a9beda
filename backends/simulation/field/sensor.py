"""A seismic sensor, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass

from typing_extensions import override

from handcart.backends.simulation.world.material import Material
from handcart.backends.simulation.world.placed_thing import PlacedThing

ORANGE_MATERIAL = Material(0.93, 0.45, 0.10, 0.3)


@dataclass(eq=False, repr=False)
class Sensor(PlacedThing):
    """Seismic sensor that stays where the hand released it.

    The origin of its frame is in the middle of its bottom face; z points up.
    """

    KIND = "sensor"

    @property
    @override
    def material(self) -> Material:
        return ORANGE_MATERIAL
