"""The objects of a simulated world."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.hand_rule import HandRule
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.solids import Solid
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import FloatArray

from .carried_object import CarriedObject
from .pull_spec import PullSpec
from .puller import OfferingHand, Puller, SimulatedPull
from .spec import ObjectsSection

FLOOR_DEPTH_M = 0.05
FLOOR_GREY = 95  # as the floor around it
CARRIED_OFF_M = 3.0  # height at which a person keeps what was taken, out of the way of everything


class ObjectProps(Props[ObjectsSection]):
    """Objects of a simulated world that a person sets down and robot hands carry, by their names.

    A person pulls at the held object at the times in the world's file, and keeps it if the hand releases it
    during a pull.
    """

    section = ObjectsSection
    STATE: ClassVar[Kinds] = {
        "objects": dict[str, CarriedObject],
        "pulls": list[SimulatedPull],
        "held_out": OfferingHand | None,
    }

    _is_glued = False
    """True without physics, where nothing slips in the hand by itself."""

    @override
    @classmethod
    def solids(cls, spec: ObjectsSection) -> Sequence[Solid]:
        """Return the areas of the floor that carry objects, as slabs whose top is at height 0."""
        slabs = []
        for area in spec.floor_areas:
            pose = Pose2(area.x_m, area.y_m, math.radians(area.heading_deg)).lift(-FLOOR_DEPTH_M / 2)
            slabs.append(Solid(Box(pose, (*area.size_m, FLOOR_DEPTH_M), area.name), grey=FLOOR_GREY))
        return slabs

    @override
    def set_up(self) -> None:
        self.objects = {
            spec.name: CarriedObject.set_down(self.scene, spec, self.seed) for spec in self.spec.objects
        }

    @cached_property
    def puller(self) -> Puller:
        """Simulated person who pulls at an object in the robot's hand, as the world's file states."""
        return Puller(self.scene, self.seed, (SimulatedPull(spec) for spec in self.spec.pulls), None)

    @property
    def pulls(self) -> list[SimulatedPull]:
        """All pulls of the simulated person at the held object, whether they are past, under way, or still to
        come.
        """
        return self.puller.pulls

    @pulls.setter
    def pulls(self, pulls: list[SimulatedPull]) -> None:
        self.puller.pulls = list(pulls)

    @property
    def held_out(self) -> OfferingHand | None:
        """Position of a hand that holds an object out at rest, and the time at which it came to rest.

        None if no hand holds an object out.
        """
        return self.puller.held_out

    @held_out.setter
    def held_out(self, held_out: OfferingHand | None) -> None:
        self.puller.held_out = held_out

    def pull_now(self, spec: PullSpec) -> None:
        """Let a person pull at the object in the hand from now on, in addition to the pulls that the world's
        file plans.
        """
        self.puller.pulls.append(SimulatedPull(spec, self.scene.time))

    @override
    def things(self) -> Iterable[CarriedObject]:
        return self.objects.values()

    @override
    def step(self) -> None:
        if not self.puller.pulls:
            return
        self.puller.step()
        held = self.scene.held
        if not self._is_glued or not isinstance(held, CarriedObject):
            return
        if self.puller.tears(held.mass, held.spec.friction):
            self.scene.held = None
            self.let_go(held)

    @override
    def hand_rule(self, arm: ArmModel) -> HandRule | None:
        self._is_glued = True
        return None

    @override
    def hand_force(self) -> FloatArray:
        force = self.puller.force
        if not force.any() or not isinstance(self.scene.held, CarriedObject):
            return np.zeros(3)
        return np.asarray(self.scene.world_T("hand")[:3, :3].T @ force)

    @override
    def let_go(self, thing: Thing) -> None:
        if not self._was_taken(thing):
            super().let_go(thing)
        self.puller.released()

    @override
    def rested(self, thing: Thing) -> None:
        if thing.rest is Rest.PERSON:
            return
        if thing.rest is Rest.HAND:
            taken = self._was_taken(thing)
            self.puller.released()
            if taken:
                return
        super().rested(thing)

    def _was_taken(self, thing: Thing) -> bool:
        """Return whether the person who pulls keeps an object that the hand releases; note it if so."""
        if not self.puller.takes():
            return False
        thing.rest, thing.pose = Rest.PERSON, carried_off(thing.pose)
        self.scene.changes += 1
        return True


def carried_off(pose: Transform) -> Transform:
    """Return the world pose (4, 4), far from the robot, of an object that a person took from the hand.

    Args:
        pose: (4, 4) pose of the object in the world when it was taken.
    """
    x, y = pose[:2, 3].tolist()
    return transform((x, y, CARRIED_OFF_M))
