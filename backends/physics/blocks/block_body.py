"""A block as a body."""

from __future__ import annotations

from handcart.backends.physics.engine.thing_form import Sticks
from handcart.backends.physics.world.thing_body import ThingBody


class BlockBody(ThingBody):
    """Body of a block in a physics engine, which static friction holds at its place in a wall.

    Without this friction, a block that is pressed between two others would creep away under any small force.
    """

    STICKS = Sticks(stiffness=1e6, damping=1e4)
