"""A seismic sensor, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass

from handcart.backends.simulation.world.placed_thing import PlacedThing


@dataclass(eq=False, repr=False)
class Sensor(PlacedThing):
    """Lies where the hand let it go. Its frame: origin in the middle of its foot, z up."""

    KIND = "sensor"
