"""Interface of a domain's objects for a scene."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar, Self

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.sheet import Sheet
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .grasp import Pads, fits, hand_T_gripped, thickness
from .hand_rule import HandRule
from .painting import Painted, paint_thing


class SceneProps(ABC):
    """Interface through which a scene handles the things of one application domain.

    Domains derive their things from `Props`, which implements it for passive boxes.
    """

    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types: its things, and what else changes."""

    @classmethod
    @abstractmethod
    def none_in(cls, scene: Any) -> Self:
        """Return an empty collection of the things of one application domain, for a scene whose file names no
        such things.
        """

    def things(self) -> Iterable[Thing]:
        """Return the things that hands can carry, in a fixed order."""
        return ()

    def sheets(self) -> Sequence[Sheet]:
        """Return the printed sheets on level surfaces."""
        return ()

    def painted(self, rests: frozenset[Rest]) -> Iterable[Painted]:
        """Yield the drawable surfaces of the things whose support (such as a table or the hand) is among
        `rests`.
        """
        for thing in self.things():
            if thing.rest in rests:
                yield paint_thing(thing)

    def base_gap(self, base: Pose2) -> tuple[float, str]:
        """Return the distance from the body of a base at a pose world_T_base to the nearest thing that stops
        it, in [m], and the thing's name; below zero if they overlap, infinity if no thing stops a base.
        """
        return math.inf, ""

    # What happens

    def taken(self, thing: Thing) -> None:
        """Record that the hand has lifted a thing: only the hand supports it now."""
        thing.rest = Rest.HAND

    def step(self) -> None:
        """Begin a control period: update those things of the domain that move or change without the robot."""

    def hand_force(self) -> FloatArray:
        """Return the force (3,) on the hand from the things of one application domain, in the hand frame, in
        [N].
        """
        return np.zeros(3)

    # Props in a hand without physics

    def hand_rule(self, arm: ArmModel) -> HandRule | None:
        """Return the rule for contacts of the hand with the things of a domain (a kind of task); None if
        these things are rigid and need no rule of their own.

        It is called once for a scene.
        """
        return None

    def thickness(self, thing: Thing, pads: Pads) -> float:
        """Return the thickness of a thing in the direction in which the finger pads close, in [m]."""
        return thickness(thing, pads)

    def fits(self, thing: Thing, pads: Pads) -> bool:
        """Return whether the finger pads would hold a thing if they closed at their present pose."""
        return fits(thing, pads)

    def gripped(self, thing: Thing, pads: Pads) -> Transform:
        """Return hand_T_thing (4, 4) after the pads have closed on the thing."""
        return hand_T_gripped(thing, pads)

    @abstractmethod
    def let_go(self, thing: Thing) -> None:
        """Release a thing from the fingers: set the pose that it takes then, and its support, such as a
        table.
        """

    # Props in a physics engine

    def awake(self, hand: FloatArray) -> Iterable[Thing]:
        """Return the things whose poses are read from the physics engine after a period, as it may have moved
        them.

        Args:
            hand: (3,) position of the hand in the world, in [m].
        """
        return self.things()

    @abstractmethod
    def rested(self, thing: Thing) -> None:
        """Update what a released thing rests on, after the physics engine has moved the thing."""
