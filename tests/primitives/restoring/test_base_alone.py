"""A base without an arm is driven back along its way, faster than it came."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail
from tests.primitives.conftest import Rig


class Creep(ActionPrimitive):
    """Drive ahead or turn slowly, then fail."""

    needs: ClassVar = (Base,)

    turn_rate: float = 0.0

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(60):
            robot.base.drive(0.0 if self.turn_rate else 0.06, self.turn_rate)
            yield
        raise Discrepancy("it is enough")


@pytest.mark.parametrize("turn_rate", [0.0, 0.2])
def test_robot_without_an_arm_is_driven_back(make_rig: Callable[..., Rig], turn_rate: float) -> None:
    rig = make_rig(robot="cart")
    start = rig.robot.pose
    failed = rig.run(Creep(turn_rate=turn_rate))
    assert isinstance(failed, Fail), failed
    assert rig.robot.pose.distance(start) < 0.03
