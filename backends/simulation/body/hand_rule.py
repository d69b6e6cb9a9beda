"""What decides where a hand without physics meets things that give way."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.thing import Thing
from handcart.robotics.geometry.transform import Transform

STIFFNESS = 2000.0  # of the arm under position control [N/m]
FORCE_CAP = 60.0  # what the hand can press with before its drives give way [N]

Vector = NDArray[np.float64]


class Met(NamedTuple):
    """How far the arm comes."""

    joints: Vector
    """Where it stops, (n,) in [rad]: the very array that was given, if nothing holds it up."""
    force: float = 0.0
    """With which it is pushed back along the hand's x, in [N]."""
    pairs: frozenset[tuple[str, str]] = frozenset()
    """What touches."""


class HandRule:
    """Stands in for rigid geometry between the hand and a domain's things; by default it decides nothing.

    In each motion of the arm `aim`, `decides`, `meet` and `carry` are asked, in this order.
    """

    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types."""
    strain: float = 0.0
    """How far the hand wrenches what it holds, as a share of what stops the arm."""
    strained_by = ""
    """What stops it then."""

    def aim(self, joints: Vector) -> None:
        """The arm strives for these joints (n,)."""

    def decides(self, body: str, other: str) -> bool:
        """Whether it, and not rigid geometry, says what comes of a body of the robot and another one."""
        return False

    def meet(self, start: Vector, joints: Vector) -> Met:
        """How far the arm gets from `start` towards `joints`, (n,) each; moves what gives way."""
        return Met(joints)

    def carry(self, thing: Thing, world_T_hand: Transform, start: Vector) -> Vector:
        """The hand has brought `thing`, which it holds, where its pose is: put that right.

        Gives the force (3,) in [N] on the hand, in its frame. `start` (n,) are the joints it comes from.
        """
        return np.zeros(3)

    def room(self) -> float:
        """How far the fingers can open where they are, in [m]."""
        return float("inf")

    def gripped(self, thing: Thing) -> None:
        """The fingers have closed about a thing; its pose is still where it stood."""
