"""Interface of a domain's objects for a scene."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar, Self

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.sheet import Sheet
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .grasp import Pads, fits, hand_T_gripped, thickness
from .hand_rule import HandRule
from .painting import Painted, paint_thing


class SceneProps(ABC):
    """Things of a domain in a scene: how they look, are gripped and let go, and what they do; see `Props`."""

    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types: its things, and what else changes."""

    @classmethod
    @abstractmethod
    def none_in(cls, scene: Any) -> Self:
        """Return the empty props of a `Scene` whose world's file has no keys of the domain."""

    def things(self) -> Iterable[Thing]:
        """Return the things that hands can carry, in a fixed order."""
        return ()

    def sheets(self) -> Sequence[Sheet]:
        """Return the printed sheets on level surfaces."""
        return ()

    def painted(self, rests: frozenset[Rest]) -> Iterable[Painted]:
        """Yield the surfaces that the camera sees of things with one of these rests."""
        for thing in self.things():
            if thing.rest in rests:
                yield paint_thing(thing)

    # What happens

    def taken(self, thing: Thing) -> None:
        """Mark a thing as carried by the hand alone."""
        thing.rest = Rest.HAND

    def step(self) -> None:
        """Begin a period: let things change by themselves."""

    def hand_force(self) -> FloatArray:
        """Return the force (3,) that the props add to the hand's reading, in the hand frame, in [N]."""
        return np.zeros(3)

    # Props in a hand without physics

    def hand_rule(self, arm: ArmModel) -> HandRule | None:
        """Return the rule that replaces rigid geometry between the hand and these things; called once."""
        return None

    def thickness(self, thing: Thing, pads: Pads) -> float:
        """Return the thickness of a thing between the pads, in [m]."""
        return thickness(thing, pads)

    def fits(self, thing: Thing, pads: Pads) -> bool:
        """Return whether closing pads meet a thing so that they can hold it."""
        return fits(thing, pads)

    def gripped(self, thing: Thing, pads: Pads) -> Transform:
        """Return hand_T_thing (4, 4) after the pads have closed on the thing."""
        return hand_T_gripped(thing, pads)

    @abstractmethod
    def let_go(self, thing: Thing) -> None:
        """Release a thing from the fingers: set its pose and its support."""

    # Props in a physics engine

    def awake(self, hand: FloatArray) -> Iterable[Thing]:
        """Return the things that the physics engine may have moved in this period.

        Args:
            hand: (3,) position of the hand in the world, in [m].
        """
        return self.things()

    @abstractmethod
    def rested(self, thing: Thing) -> None:
        """Set the support of a thing that is not held, after physics has set its pose."""
