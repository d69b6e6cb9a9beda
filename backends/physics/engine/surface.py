"""Surfaces of the robot's links."""

from __future__ import annotations

from typing import NamedTuple

from handcart.backends.simulation.world.grasp import PAD_FRICTION


class ContactSurface(NamedTuple):
    """Contact properties of a link, such as friction and stiffness.

    The engine keeps its own value of each property that is None.
    """

    friction: float | None = None
    """Coulomb's coefficient of friction."""
    stiffness: float | None = None
    """Stiffness of each contact point, in [N/m], as of rubber."""
    damping: float | None = None
    """Damping of each contact point, in [Ns/m]."""
    sticks: bool = False
    """True if a touched body keeps its place on it while friction holds."""
    along_axle: float | None = None
    """Friction along the axle, the link's y axis, as a share of that across the axle; None leaves it
    unchanged.
    """
    against: float = 1.0
    """Coefficient of the surface that it mostly touches, for engines with one coefficient for a pair."""
    sinks: float = 0.0
    """Compliance of the ground under the link, in [m/N], in addition to the link's own."""

    @property
    def point_stiffness(self) -> float | None:
        """Return the stiffness of a contact point between this surface and the ground, in [N/m].

        The surface and the ground act as two springs in series. The result is None if the engine's own
        stiffness applies.
        """
        if self.sinks == 0.0 or self.stiffness is None:
            return self.stiffness
        return 1.0 / (1.0 / self.stiffness + self.sinks)


TYRE_SURFACE = ContactSurface(friction=1.0)
"""Tyre of rubber."""
CASTER_SURFACE = ContactSurface(friction=0.0, stiffness=1e6, damping=2e4)
"""Frictionless surface on springs, as a model of a wheel that turns in any direction.

It gives by 0.2 mm under 200 N. A caster as hard as the wheels might take all the weight off them, and the
base would slide on.
"""
SCRUBBING_SURFACE = ContactSurface(
    stiffness=CASTER_SURFACE.stiffness, damping=CASTER_SURFACE.damping, sticks=True, along_axle=0.1
)
"""Tyre of one of several wheels a side, which slide sideways in a turn. They share the base's weight
as they give a little, and at rest they stick."""
SOFT_TYRES = ContactSurface(stiffness=3e5, damping=6e3, sticks=True)
"""Tyres of a car on rough ground; they stick at rest."""
PAD_SURFACE = ContactSurface(friction=PAD_FRICTION, stiffness=1e5, damping=1000.0, sticks=True, against=0.65)
"""Finger pad of rubber, soft so that it presses with all corners; a rigid one would press with one."""
