"""Check of the hand on the last millimetres of PLACE, and on its way back."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.objects.holding.placing_plan import (
    ABOVE_GOAL_M,
    FREE_ABOVE_M,
    _can_withdraw,
    _PlacingModels,
)
from handcart.robotics.geometry.transform import raised, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.manipulation.motions.motion_planner import plan_straight

GOAL = transform((0.5, 0.0, 0.8), (0.0, np.pi / 2, 0.0))  # the hand points down


@pytest.mark.parametrize(("height", "is_free"), [(None, True), (0.8, False), (0.87, False), (1.2, True)])
def test_hand_at_the_goal_and_on_its_way_back_is_checked(height: float | None, is_free: bool) -> None:
    robot = load_robot("librarian")
    arm, home = robot.arm_model(), np.array(robot.posture("search_ready"))
    rim = () if height is None else (Box(transform((0.5, 0.0, height)), (0.02, 0.02, 0.02), "rim"),)
    own = CollisionModel(arm)
    models = _PlacingModels(own, own, CollisionModel(arm, rim))
    start = arm.inverse(raised(GOAL, ABOVE_GOAL_M), home, restarts=20)
    assert start is not None
    above = plan_straight(arm, start, raised(GOAL, FREE_ABOVE_M))
    below = plan_straight(arm, start, raised(GOAL, -FREE_ABOVE_M))
    assert above is not None and below is not None
    assert _can_withdraw(models, above[-1], below[-1], GOAL) is is_free
