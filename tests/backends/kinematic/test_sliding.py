"""A hand that presses on a surface slides along it, against friction."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.body.sliding import HAND_FRICTION, push_out
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray
from tests.backends.kinematic.conftest import Puppet

DESK_M = 0.75
FINGER_M = 0.03
"""Height of a finger, half of which is below the hand's frame."""


@pytest.fixture
def at_desk(puppet: Puppet) -> Puppet:
    """Before the middle of the desk's long side, the closed hand over it."""
    puppet.scene.move_base(Pose2(0.68, 1.25, np.radians(-80.0)))
    puppet.to(0.10, 0.0, 0.90)
    puppet.fingers(0.0)
    puppet.to(0.45, -0.05, 0.90)
    return puppet


def hand(puppet: Puppet) -> FloatArray:
    """Return the true position of the hand, in the base frame."""
    return np.asarray(puppet.scene.arm.forward(puppet.scene.joints)[:3, 3])


@pytest.mark.parametrize("further", [0.0, 0.001, 0.003])
def test_wiping_hand_follows_the_surface_against_friction(at_desk: Puppet, further: float) -> None:
    at_desk.to(0.45, -0.05, 0.80)
    pressed = 0.010
    surface = lowered(at_desk)
    at_desk.to(0.45, -0.05, surface - pressed)
    touched = hand(at_desk)
    force = at_desk.scene.hand_force
    assert force[2] == pytest.approx(2000.0 * pressed, rel=0.1)
    at_desk.to(0.45, 0.10, surface - pressed)
    at_desk.to(0.45, 0.10 + further, surface - pressed)
    wiped, force = hand(at_desk), at_desk.scene.hand_force
    assert wiped[1] - touched[1] == pytest.approx(0.15 + further - HAND_FRICTION * pressed, abs=7e-4)
    assert wiped[2] == pytest.approx(touched[2], abs=5e-4)
    assert force[2] == pytest.approx(2000.0 * pressed, rel=0.1)
    assert force[1] == pytest.approx(-HAND_FRICTION * 2000.0 * pressed, rel=0.15)
    assert {contact.other for contact in at_desk.scene.contacts} == {"desk"}


def lowered(puppet: Puppet) -> float:
    """Lower the hand until it feels something; return the height of its frame there."""
    height = 0.80
    while puppet.scene.hand_force[2] < 2.0:
        height -= 0.002
        puppet.to(0.45, -0.05, height)
    return float(hand(puppet)[2])


def test_a_hand_is_pushed_out_at_any_turn_of_an_endless_joint() -> None:
    """The joint has turned twice around; it was clipped to half a turn, and the arm swung around."""
    spec = load_robot("librarian")
    assert spec.arm is not None
    urdf = ElementTree.fromstring(spec.urdf_text())
    first = next(joint for joint in urdf.iter("joint") if joint.get("name") == spec.arm.joints[0])
    first.set("type", "continuous")
    arm = ArmModel(ElementTree.tostring(urdf, encoding="unicode"), spec.arm.joints)
    joints = arm.clipped(np.full(arm.dof, 0.3)) + np.eye(arm.dof)[0] * 4.0 * np.pi
    pushed = push_out(arm, joints, np.array([0.0, 0.002, 0.0]))
    assert np.abs(pushed - joints).max() < 0.05


def test_hand_sticks_within_the_cone_of_friction(at_desk: Puppet) -> None:
    surface = lowered(at_desk)
    at_desk.to(0.45, -0.05, surface - 0.010)
    touched = hand(at_desk)
    at_desk.to(0.45, -0.05 + 0.9 * HAND_FRICTION * 0.010, surface - 0.010)
    assert hand(at_desk) == pytest.approx(touched, abs=3e-4)
    at_desk.to(0.45, -0.05, surface + 0.05)
    assert hand(at_desk) == pytest.approx((0.45, -0.05, surface + 0.05), abs=2e-3)
    assert at_desk.scene.hand_force == pytest.approx(np.zeros(3), abs=1e-9)


def test_hand_that_slides_stops_at_what_stands_there(at_desk: Puppet) -> None:
    """Off the desk's edge it goes down to its command; it never stands in anything."""
    surface = lowered(at_desk)
    at_desk.to(0.45, -0.05, surface - 0.010)
    at_desk.to(0.45, 0.45, surface - 0.010)
    hand_of_robot = at_desk.backend._hand
    assert hand_of_robot is not None
    assert hand_of_robot.contact.deepest_of_arm(at_desk.scene.joints).depth < 1e-4
    assert hand(at_desk)[2] == pytest.approx(surface - 0.010, abs=2e-3)


def test_hand_does_not_jump_where_no_small_motion_slides_it(
    at_desk: Puppet, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Near a singular posture, steps by the Jacobian lead far away."""
    surface = lowered(at_desk)
    at_desk.to(0.45, -0.05, surface - 0.010)
    touched, joints = hand(at_desk), at_desk.scene.joints
    far = joints + np.array([0.6, *np.zeros(len(joints) - 1)])
    monkeypatch.setattr("handcart.backends.simulation.body.hand.slide", lambda *_: far)
    at_desk.to(0.45, -0.02, surface - 0.010)
    assert hand(at_desk) == pytest.approx(touched, abs=3e-4)
