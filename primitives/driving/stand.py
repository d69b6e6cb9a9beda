"""STAND: stand still for a while."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView


class Stand(ActionPrimitive):
    """Stand still: outdoors the gyros' bias is learned so, and where the robot is gets better known."""

    seconds: Annotated[float, Field(gt=0.0, le=3600.0)]
    """How long."""

    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield from robot.wait(self.seconds)
