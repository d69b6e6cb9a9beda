"""A block as a body."""

from __future__ import annotations

from handcart.backends.physics.thing_form import Sticks
from handcart.backends.physics.world.thing_body import ThingBody


class BlockBody(ThingBody):
    """A box that stays where it stands in a wall.

    Else a block that is pressed between two others would creep away, however little pushes it.
    """

    STICKS = Sticks(stiffness=1e6, damping=1e4)
