"""STOW: bring arm and load within the robot's outline."""

from __future__ import annotations

from typing import ClassVar

from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView

from .carrying import stow
from .object_site import surroundings
from .objects import Objects


class Stow(ActionPrimitive):
    """Bring the hand within the robot's outline, so that the base may drive.

    An empty hand goes to the posture `home`; a held object that has to stay upright is carried upright.
    """

    needs: ClassVar = (Arm,)
    reads: ClassVar = ("objects", "sightings", "held_object")

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        objects = model.of(Objects)
        held, around = objects.held_object, surroundings(robot, model)
        if held is None:
            yield from stow(robot, around)
            return
        kind = objects.objects.kind_of(held.object)
        yield from stow(robot, around, kind, held.hand_T_object)
