"""A block, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass

from handcart.backends.simulation.world.placed_thing import PlacedSpec, PlacedThing


class BlockSpec(PlacedSpec):
    """A block, and where a person sets it down: the middle of its foot."""


@dataclass(eq=False, repr=False)
class Block(PlacedThing):
    """A block of a wall and where it truly is.

    Its frame: origin in the middle of its foot; x along its length, y along its width, z up.
    """

    KIND = "block"

    spec: BlockSpec
