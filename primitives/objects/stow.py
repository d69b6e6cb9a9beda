"""STOW: bring arm and load within the robot's outline."""

from __future__ import annotations

from typing import ClassVar

from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.holding.carrying import stow
from handcart.primitives.objects.knowledge.objects import Objects


class Stow(ActionPrimitive):
    """Bring the hand within the robot's outline, so that the base may drive.

    An empty hand goes to the posture `home`; a held object that has to stay upright is carried upright.
    """

    needs: ClassVar = (Arm,)
    reads: ClassVar = ("map", "sensed_cells", "objects", "sightings", "held_object")

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        objects = model.of(Objects)
        held = objects.held_object
        if held is None:
            yield from stow(robot, model)
            return
        kind = objects.objects.kind_of(held.object)
        yield from stow(robot, model, kind, held.hand_T_object)
