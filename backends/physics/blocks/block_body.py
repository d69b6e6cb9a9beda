"""A block as a body."""

from __future__ import annotations

from handcart.backends.physics.engine.thing_form import Sticks
from handcart.backends.physics.world.thing_body import ThingBody


class BlockBody(ThingBody):
    """Box that stays at its place in a wall.

    Otherwise a block pressed between two others would creep away under any small force.
    """

    STICKS = Sticks(stiffness=1e6, damping=1e4)
