"""Kinematics of the librarian's arm and of a small foreign one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import difference, inverse, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box, Cylinder
from tests.robotics.kinematics.singular import smallest_gain

FOREIGN = """
<robot name="foreign">
  <link name="floor"/>
  <link name="stand"><collision><geometry><cylinder radius="0.1" length="0.5"/></geometry></collision></link>
  <link name="turret"/>
  <link name="slide"/>
  <link name="tool">
    <collision><origin xyz="0 0 0.1"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
  </link>
  <joint name="bolt" type="fixed">
    <parent link="floor"/><child link="stand"/><origin xyz="1 2 0" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="turn" type="continuous">
    <parent link="stand"/><child link="turret"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="push" type="prismatic">
    <parent link="turret"/><child link="slide"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.5" effort="1" velocity="0.2"/>
  </joint>
  <joint name="tilt" type="revolute">
    <parent link="slide"/><child link="tool"/><origin xyz="0.2 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="0.7"/>
  </joint>
</robot>
"""


def _turn(axis: str, angle: float) -> np.ndarray:
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler(axis, angle).as_matrix()
    return result


def _by_hand(q: np.ndarray) -> np.ndarray:
    """base_T_hand, one joint after the other, from the drawing of the arm."""
    pose: np.ndarray = (
        transform((-0.155, 0.215, 0.80))
        @ _turn("z", q[0])
        @ transform((0.0, 0.10, 0.08))
        @ _turn("y", q[1])
        @ transform((0.46, -0.10, 0.0))
        @ _turn("y", q[2])
        @ transform((0.16, 0.0, 0.0))
        @ _turn("x", q[3])
        @ transform((0.33, 0.0, 0.0))
        @ _turn("y", q[4])
        @ _turn("x", q[5])
        @ transform((0.08, 0.0, 0.0))
    )
    return pose


def _random(arm: ArmModel, count: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(arm.lower, arm.upper, (count, arm.dof))


def test_forward_stretched_out(arm: ArmModel) -> None:
    np.testing.assert_allclose(arm.forward(np.zeros(6)), transform((0.875, 0.215, 0.88)), atol=1e-9)


def test_forward_matches_the_drawing(arm: ArmModel) -> None:
    for q in _random(arm, 50, seed=1):
        np.testing.assert_allclose(arm.forward(q), _by_hand(q), atol=1e-9)


def test_camera_looks_along_the_hand(arm: ArmModel) -> None:
    hand_T_camera = inverse(arm.forward(np.zeros(6))) @ arm.forward(np.zeros(6), frame="camera")
    expected = np.array([[0, 0, 1, 0.03], [-1, 0, 0, 0.08], [0, -1, 0, 0], [0, 0, 0, 1.0]])
    np.testing.assert_allclose(hand_T_camera, expected, atol=1e-8)


def test_a_posture_asked_again_is_the_same_for_each_frame(arm: ArmModel) -> None:
    q = 0.5 * (arm.lower + arm.upper)
    hand, base = arm.forward(q).copy(), arm.forward(q, "base")
    assert np.allclose(base, np.eye(4))
    taken = arm.forward(q)
    taken[:] = 0.0
    assert np.array_equal(arm.forward(q), hand)
    assert not np.array_equal(arm.forward(q + 0.1), hand)


def test_jacobian_matches_differences(arm: ArmModel) -> None:
    h = 1e-5
    for q in _random(arm, 20, seed=2):
        J = arm.jacobian(q)
        for joint in range(6):
            ahead, behind = (arm.forward(q + sign * h * np.eye(6)[joint]) for sign in (1, -1))
            linear = (ahead[:3, 3] - behind[:3, 3]) / (2 * h)
            angular = Rotation.from_matrix(ahead[:3, :3] @ behind[:3, :3].T).as_rotvec() / (2 * h)
            np.testing.assert_allclose(J[:, joint], np.concatenate((linear, angular)), atol=1e-8)


@pytest.mark.slow
def test_inverse_reaches_random_poses_from_far(arm: ArmModel) -> None:
    poses, nears = _random(arm, 300, seed=3), _random(arm, 300, seed=4)
    reached = 0
    for truth, near in zip(poses, nears, strict=True):
        q = arm.inverse(arm.forward(truth), near)
        if q is not None:
            assert np.all(q >= arm.lower) and np.all(q <= arm.upper)
            assert max(difference(arm.forward(q), arm.forward(truth))) < 1e-7
            reached += 1
    assert reached >= 0.98 * len(poses)


def test_inverse_from_near_stays_near(arm: ArmModel) -> None:
    noise = np.random.default_rng(6).uniform(-0.02, 0.02, (100, 6))
    middle = 0.5 * (arm.lower + arm.upper)
    for truth, shift in zip(middle + 0.5 * (_random(arm, 100, seed=5) - middle), noise, strict=True):
        q = arm.inverse(arm.forward(truth), np.clip(truth + shift, arm.lower, arm.upper), restarts=0)
        assert q is not None
        if smallest_gain(arm, truth) > 0.05:
            np.testing.assert_allclose(q, truth, atol=1e-4)


def test_inverse_out_of_reach_is_none(arm: ArmModel) -> None:
    assert arm.inverse(transform((3.0, 0.0, 0.5)), np.zeros(6), restarts=2) is None


def test_inverse_repeats_itself(arm: ArmModel) -> None:
    target = arm.forward(_random(arm, 1, seed=7)[0])
    far = _random(arm, 1, seed=8)[0]
    np.testing.assert_array_equal(arm.inverse(target, far, seed=9), arm.inverse(target, far, seed=9))


def test_fingers_open(arm: ArmModel) -> None:
    opened = arm.with_others({"left_finger": 0.02, "right_finger": 0.02})
    shapes = {shape.name: shape for shape in opened.link_shapes(np.zeros(6))}
    hand_y = opened.forward(np.zeros(6))[1, 3]
    assert shapes["left_finger"].pose[1, 3] - hand_y == pytest.approx(0.02075)
    assert shapes["right_finger"].pose[1, 3] - hand_y == pytest.approx(-0.02075)


def test_link_shapes_are_those_of_the_file(arm: ArmModel) -> None:
    shapes = arm.link_shapes(np.zeros(6))
    tray = next(shape for shape in shapes if shape.name == "tray" and isinstance(shape, Box))
    assert tray.pose[2, 3] + tray.size[2] / 2 == pytest.approx(0.62)
    bodies = [shape for shape in shapes if shape.name == "base" and isinstance(shape, Cylinder)]
    assert all(body.radius <= 0.34 for body in bodies)
    np.testing.assert_array_equal(arm.link_poses(np.zeros(6)), [shape.pose for shape in shapes])


def test_foreign_arm_in_any_order_of_joints() -> None:
    arm = ArmModel(FOREIGN, ["tilt", "push", "turn"], tip="tool", base="stand")
    np.testing.assert_allclose(arm.lower, [-1.0, 0.0, -math.pi])
    np.testing.assert_allclose(arm.velocity[:2], [0.7, 0.2])
    expected = transform((0.0, 0.0, 0.5)) @ _turn("z", 0.5) @ transform((0.5, 0.0, 0.0)) @ _turn("y", 0.2)
    np.testing.assert_allclose(arm.forward(np.array([0.2, 0.3, 0.5])), expected, atol=1e-9)
    q = arm.inverse(expected, near=np.array([0.0, 0.1, 0.0]))
    assert q is not None
    np.testing.assert_allclose(q, [0.2, 0.3, 0.5], atol=1e-6)
    tool = arm.link_shapes(np.array([0.2, 0.3, 0.5]))[-1]
    np.testing.assert_allclose(tool.pose, expected @ transform((0.0, 0.0, 0.1)), atol=1e-9)


def test_standing_joints_keep_their_place() -> None:
    arm = ArmModel(FOREIGN, ["tilt"], tip="tool", base="stand", others={"turn": 0.5, "push": 0.3})
    expected = transform((0.0, 0.0, 0.5)) @ _turn("z", 0.5) @ transform((0.5, 0.0, 0.0)) @ _turn("y", 0.2)
    np.testing.assert_allclose(arm.forward(np.array([0.2])), expected, atol=1e-9)


def test_what_is_not_there_is_named(urdf: str) -> None:
    with pytest.raises(ValueError, match=r"no movable joint 'elbow'.*joint_3"):
        ArmModel(urdf, ["elbow"])
    with pytest.raises(ValueError, match="no link 'claw'"):
        ArmModel(urdf, ["joint_1"], tip="claw")
    with pytest.raises(ValueError, match="'link_3' can't be the base"):
        ArmModel(urdf, ["joint_1"], base="link_3")
    with pytest.raises(ValueError, match="not well-formed"):
        ArmModel("<robot>", [])
