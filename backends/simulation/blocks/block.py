"""A block, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass

from typing_extensions import override

from handcart.backends.simulation.world.material import Material
from handcart.backends.simulation.world.placed_thing import PlacedSpec, PlacedThing

BRICK_MATERIAL = Material(0.76, 0.40, 0.28, 0.05)


class BlockSpec(PlacedSpec):
    """A block, and where a person sets it down: the middle of its foot."""


@dataclass(eq=False, repr=False)
class Block(PlacedThing):
    """A block of a wall and where it truly is.

    Its frame: origin in the middle of its foot; x along its length, y along its width, z up.
    """

    KIND = "block"

    spec: BlockSpec

    @property
    @override
    def material(self) -> Material:
        return BRICK_MATERIAL
