"""Tests of a robot that holds still for a person and pushes nothing aside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.halt import PRESSING_FORCE_N
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import NeedsPerson
from handcart.primitives.outcomes.outcome import GiveUp
from tests.primitives.conftest import Rig

GOES = 0.01  # [rad]


class Pushes(ActionPrimitive):
    """Turns the arm's first joint, and needs a person."""

    needs: ClassVar = (Arm,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(10):
            robot.arm.move(robot.arm.command() + np.array([GOES / 10, 0.0, 0.0, 0.0, 0.0, 0.0]))
            yield
        raise NeedsPerson("it squeaks")


@pytest.mark.parametrize(("stiffness", "follows"), [(3000.0, False), (0.0, True)], ids=["jammed", "encoders"])
def test_an_arm_that_is_jammed_holds_where_it_stands(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch, stiffness: float, follows: bool
) -> None:
    """An arm whose encoders alone are stuck keeps its command."""
    rig = make_rig()
    arm: Any = rig.robot.backend.get(Arm)
    stands, began = arm.joints().copy(), arm.command().copy()
    monkeypatch.setattr(arm, "joints", lambda: stands.copy())

    def force() -> Any:
        return np.array([0.0, -stiffness * (arm.command()[0] - stands[0]), 0.0])

    monkeypatch.setattr(arm, "hand_force", force)
    assert rig.run(Pushes()) == GiveUp("it squeaks")
    began[0] += GOES
    assert arm.command() == pytest.approx(began if follows else stands, abs=1e-9)


def test_what_an_arm_is_jammed_in_may_follow(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """After one command to hold its measured pose, the arm presses with half of the force."""
    rig = make_rig()
    arm: Any = rig.robot.backend.get(Arm)
    free = arm.command().copy()
    monkeypatch.setattr(arm, "joints", lambda: (arm.command() + free) / 2)

    def force() -> Any:
        return np.array([0.0, -6000.0 * (arm.joints()[0] - free[0]), 0.0])

    monkeypatch.setattr(arm, "hand_force", force)
    assert rig.run(Pushes()) == GiveUp("it squeaks")
    assert np.linalg.norm(arm.hand_force()) <= PRESSING_FORCE_N
    assert arm.command()[0] > free[0]
