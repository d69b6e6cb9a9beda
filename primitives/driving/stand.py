"""STAND: stay at rest for a while."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field
from typing_extensions import override

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView


class Stand(ActionPrimitive):
    """Stay at rest for a time, which outdoors measures the gyros' bias and improves the pose estimate."""

    seconds: Annotated[float, Field(gt=0.0, le=3600.0)]
    """Time at rest."""

    needs: ClassVar = (Base,)
    needs_pose: ClassVar = False

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield from robot.wait(self.seconds)
