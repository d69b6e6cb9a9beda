"""A seismic sensor, as a solid body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from handcart.backends.scene.placed_thing import PlacedThing


@dataclass(eq=False, repr=False)
class Sensor(PlacedThing):
    """Lies where the hand let it go. Its frame: origin in the middle of its foot, z up."""

    KIND = "sensor"
    BODIES: ClassVar[Mapping[str, str]] = {
        "pybullet": "handcart.backends.pybullet.blocks.block_body:BlockBody"
    }
