"""STOW: bring arm and load within the robot's outline."""

from __future__ import annotations

from typing import ClassVar

from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.holding.carrying import stow
from handcart.primitives.objects.holding.hold_watch import HoldWatch
from handcart.primitives.objects.knowledge.objects import Objects


class Stow(ActionPrimitive):
    """Bring the hand within the robot's outline, so that the base may drive.

    An empty hand goes to the posture `home`; a held object that has to stay upright is carried upright.
    """

    _hold: HoldWatch | None = PrivateAttr(default=None)
    """Set while an object is carried."""

    needs: ClassVar = (Arm,)
    reads: ClassVar = ("map", "sensed_cells", "objects", "sightings", "held_object")

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        objects = model.of(Objects)
        held = objects.held_object
        if held is None:
            yield from stow(robot, model)
            return
        self._hold = HoldWatch()
        kind = objects.objects.kind_of(held.object)
        yield from stow(robot, model, kind, held.hand_T_object)

    @override
    def watch(self, robot: Robot, model: ModelView) -> None:
        """Check in this period that the object has not slipped out of the hand.

        Raises:
            NeedsPerson: the object has slipped.
        """
        if self._hold is not None and self._hold.has_slipped(robot):
            raise self._hold.slipped(robot)
