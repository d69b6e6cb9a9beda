"""A block, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass

from typing_extensions import override

from handcart.backends.simulation.world.material import Material
from handcart.backends.simulation.world.placed_thing import PlacedSpec, PlacedThing

BRICK_MATERIAL = Material(0.76, 0.40, 0.28, 0.05)


class BlockSpec(PlacedSpec):
    """Description of a block in a world's file, with the pose at which a person puts the block down.

    The position is that of the middle of the block's underside (its foot).
    """


@dataclass(eq=False, repr=False)
class Block(PlacedThing):
    """A simulated block and its true pose.

    The block's frame has its origin in the middle of the underside; x along its length, y along its width, z
    up.
    """

    KIND = "block"

    spec: BlockSpec

    @property
    @override
    def material(self) -> Material:
        return BRICK_MATERIAL
