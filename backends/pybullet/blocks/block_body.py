"""A block as Bullet's body."""

from __future__ import annotations

from handcart.backends.pybullet.world.thing_body import ThingBody

STIFFNESS, DAMPING = 1e6, 1e4
"""Of each point at which a block touches something, in [N/m] and [Ns/m]."""


class BlockBody(ThingBody):
    """A box that stays where it stands in a wall."""

    def settle(self) -> None:
        """See `ThingBody`."""
        # Else a block that is pressed between two others creeps away, however little pushes it.
        self.physics.p.changeDynamics(
            self.id,
            -1,
            frictionAnchor=1,
            contactStiffness=STIFFNESS,
            contactDamping=DAMPING,
            physicsClientId=self.physics.client,
        )
