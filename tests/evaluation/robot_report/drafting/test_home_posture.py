"""The posture that a draft has for driving."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.robot_report.drafting.home_posture import home_of
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.urdf_contents import joints_of
from handcart.robotics.manipulation.motions.collision_model import CollisionModel


@pytest.mark.parametrize("name", ["librarian", "xarm_cart"])
def test_home_is_free_and_compact(name: str) -> None:
    """The most compact posture that is tried of xarm_cart has the fingers in the base."""
    if name == "xarm_cart":
        pytest.importorskip("pybullet_data", reason="its arm comes with PyBullet")
    robot = load_robot(name)
    assert robot.arm is not None
    facts = {item.name: item for item in joints_of(robot.urdf_text())}
    joints = [facts[joint] for joint in robot.arm.joints]
    home = home_of(robot.urdf_text(), "base", "hand", joints, robot.joint_units)
    arm = ArmModel(robot.urdf_text(), robot.arm.joints)
    q = np.array(robot.joint_units.si(home.posture))
    assert home.is_free
    assert CollisionModel(arm, allowed=home.always).contacts(q) == []
    assert all(arm.lower <= q)
    assert all(q <= arm.upper)
    assert home.radius < 0.6
