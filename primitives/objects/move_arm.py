"""MOVE_ARM: move the arm to a posture of the robot's file."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.site.object_site import held_shape
from handcart.primitives.objects.site.roomy_motion import move_with_room
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy


class MoveArm(ActionPrimitive):
    """Move the arm, with a held object, to a named posture without touching surfaces and seen objects."""

    posture: str
    """Name of a posture in the robot's file."""

    needs: ClassVar = (Arm,)
    reads: ClassVar = ("map", "sensed_cells", "objects", "sightings", "held_object")

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        known = robot.spec.arm.postures if robot.spec.arm is not None else {}
        if self.posture not in known:
            raise Discrepancy(
                f"the robot's file has no posture {self.posture!r}; allowed: {', '.join(known)}",
                permanent=True,
                cause=causes.NOT_KNOWN,
            )
        joints = np.array(robot.spec.posture(self.posture))
        yield from move_with_room(robot, model, joints, held_shape(model))
