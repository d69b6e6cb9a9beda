"""Inverse kinematics of arms with joints that slide, that follow others, and that turn by half a turn."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.transform import difference, transform
from handcart.robotics.kinematics.arm_model import ArmModel

JOINT = """
  <link name="{child}"/>
  <joint name="{name}" type="{kind}">
    <parent link="{parent}"/><child link="{child}"/><origin xyz="0.2 0.1 0.3" rpy="0.1 0.2 0.3"/>
    <axis xyz="{axis}"/><limit lower="-1" upper="1" effort="1" velocity="1"/>{mimic}
  </joint>"""
KINDS = (
    ("turn", "continuous", "0 0 1", ""),
    ("lift", "prismatic", "0 0.6 0.8", ""),
    ("bend", "revolute", "0 1 0", ""),
    ("follow", "revolute", "0 0.6 0.8", '<mimic joint="bend" multiplier="-0.5" offset="0.2"/>'),
    ("swing", "revolute", "1 0 0", ""),
    ("extend", "prismatic", "1 0 0", '<mimic joint="lift" multiplier="0.3" offset="-0.1"/>'),
)
NAMES = ["bend", "turn", "swing", "lift"]


def _odd_arm(tip: str = "l6") -> ArmModel:
    joints = "".join(
        JOINT.format(name=name, kind=kind, axis=axis, mimic=mimic, parent=f"l{n}", child=f"l{n + 1}")
        for n, (name, kind, axis, mimic) in enumerate(KINDS)
    )
    return ArmModel(f'<robot name="odd"><link name="l0"/>{joints}</robot>', NAMES, tip=tip, base="l0")


def test_inverse_with_followers_and_slides_reaches_the_pose() -> None:
    odd_arm, rng = _odd_arm(), np.random.default_rng(1)
    for truth in rng.uniform(-0.8, 0.8, (20, 4)):
        goal = odd_arm.forward(truth)
        found = odd_arm.inverse(goal, np.clip(truth + rng.uniform(-0.2, 0.2, 4), -1.0, 1.0), restarts=4)
        assert found is not None
        assert max(difference(odd_arm.forward(found), goal)) < 1e-7


@pytest.mark.parametrize("angle", [math.pi, -math.pi, math.pi - 1e-9, 1e-12])
def test_inverse_half_a_turn_away_reaches_the_pose(angle: float) -> None:
    joint = JOINT.format(name="turn", kind="continuous", axis="1 0 0", mimic="", parent="l0", child="l1")
    arm = ArmModel(f'<robot name="one"><link name="l0"/>{joint}</robot>', ["turn"], tip="l1", base="l0")
    goal = transform((0.2, 0.1, 0.3), (0.1, 0.2, 0.3)) @ transform(rpy=(angle, 0.0, 0.0))
    found = arm.inverse(goal, np.zeros(1), restarts=0)
    assert found is not None
    assert max(difference(arm.forward(found), goal)) < 1e-7


def test_joints_that_do_not_move_the_tip_stay() -> None:
    shorter = _odd_arm(tip="l2")
    near = np.array([0.3, 0.4, -0.2, 0.1])
    goal = shorter.forward(np.array([0.0, 1.4, 0.0, 0.5]))
    found = shorter.inverse(goal, near, restarts=3)
    assert found is not None
    np.testing.assert_allclose(found, [0.3, 1.4, -0.2, 0.5], atol=1e-6)
