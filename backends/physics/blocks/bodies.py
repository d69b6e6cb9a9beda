"""Classes of bodies in physics, for `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.simulation.blocks.block import Block

from .block_body import BlockBody

PROP_BODIES = {Block: BlockBody}
