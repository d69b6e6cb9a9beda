"""Rules for a hand without physics that meets movable things."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.thing import Thing
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

ARM_STIFFNESS_N_M = 2000.0  # of the arm under position control [N/m]
FORCE_CAP = 60.0  # force at which the hand's drives yield [N]


class Met(NamedTuple):
    """Result of an arm's motion in one period: the reached joints, the force on the hand, and the touching
    pairs.
    """

    joints: FloatArray
    """Joints (n,) at which the arm stops, in [rad] or [m]: the given array itself, if nothing stops it."""
    force: float = 0.0
    """Size of the force that pushes the hand back against its x axis, in [N]."""
    pairs: frozenset[tuple[str, str]] = frozenset()
    """Names of the robot's body and the other one of each touching pair."""


class HandRule:
    """Rule for contacts between the hand and the things of an application domain, instead of rigid geometry.

    A subclass overrides the methods; by default all contacts follow rigid geometry.

    In each motion of the arm, `aim`, `decides`, `meet` and `carry` are called in this order.
    """

    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types."""
    strain: float = 0.0
    """Torsion of the held object by the hand, as a share of the value that stops the arm."""
    strained_by = ""
    """Name of the body that stops the arm by that torsion."""

    def aim(self, joints: FloatArray) -> None:
        """Store the goal of the arm's motion: its joints (n,), in [rad] or [m]."""

    def decides(self, body: str, other: str) -> bool:
        """Return whether this rule, not rigid geometry, decides on the contact of two bodies, given their
        names.
        """
        return False

    def meet(self, start: FloatArray, joints: FloatArray) -> Met:
        """Return the joints that the arm reaches in a period, and move the things that it pushes away.

        Args:
            start: (n,) joints at the start, in [rad] or [m].
            joints: (n,) commanded joints, in [rad] or [m].
        """
        return Met(joints)

    def carry(self, thing: Thing, world_T_hand: Transform, start: FloatArray) -> FloatArray:
        """Correct the pose of the held object after the hand has moved it; return its force (3,) on the hand.

        The force is in the hand frame, in [N].

        Args:
            thing: the held object.
            world_T_hand: (4, 4) pose of the hand.
            start: (n,) joints at the start of the period, in [rad] or [m].
        """
        return np.zeros(3)

    def room(self) -> float:
        """Return the largest opening, in [m], for which things around the fingers leave room; infinity if
        none limits it.
        """
        return float("inf")

    def gripped(self, thing: Thing) -> None:
        """React to the event that the fingers have closed on a thing, whose pose is not yet updated."""
