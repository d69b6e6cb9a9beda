"""An arm by CAN measures the force on its hand if enough of its drives report their torques."""

from __future__ import annotations

import pytest

from handcart.backends.can.can_parts import capabilities_of
from handcart.backends.capabilities.arm import Arm, ForceArm
from handcart.backends.loading.robot_loading import load_robot


@pytest.mark.parametrize(("silent", "feels"), [(0, True), (3, True), (4, False), (6, False)])
def test_arm_feels_a_force_with_three_torques(silent: int, feels: bool) -> None:
    robot = load_robot("librarian")
    assert robot.can is not None
    joints = tuple(
        joint.model_copy(update={"without": ("torque",)}) if number < silent else joint
        for number, joint in enumerate(robot.can.joints)
    )
    robot = robot.model_copy(update={"can": robot.can.model_copy(update={"joints": joints})})
    kinds = capabilities_of(robot)
    assert (ForceArm in kinds, Arm in kinds) == (feels, not feels)
