"""A maker's robot in the engine: a telescope that mimics, a passive head, links that overlap."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.world_files.world_model import world_model

EMPTY = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})
ROBOT = """\
format: handcart-robot/1
urdf: crane.urdf
links: {base: base_link, hand: hook}
allowed_contacts: [[mast, base_link], [boom, base_link], [boom, mast], [hook, base_link]]
period_s: 0.05
footprint_radius_m: 0.5
localizer: odometry
drive: {left: l_joint, right: r_joint, wheel_radius_m: 0.1, tread_m: 0.6, top_speed_m_s: 0.5,
        top_turn_deg_s: 60, acceleration_m_s2: 0.5, turn_acceleration_deg_s2: 90}
arm:
  joints: [lift]
  top_speed_deg_s: 90
  acceleration_deg_s2: 180
  slide_speed_mm_s: 200
  slide_acceleration_mm_s2: 500
  postures: {home: [100]}
errors: {none: true}
tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}
"""
MASS = (
    '<inertial><mass value="{0}"/><inertia ixx="{1}" ixy="0" ixz="0" iyy="{1}" iyz="0" izz="{1}"/></inertial>'
)
SOLID = '<collision><geometry><box size="{0} {0} 0.1"/></geometry></collision>'
WHEEL = """\
  <link name="{0}">{1}<collision><origin rpy="1.5707963 0 0"/><geometry><cylinder radius="0.1" length="0.04"/>
    </geometry></collision></link>
  <joint name="{0}_joint" type="continuous"><parent link="base_link"/><child link="{0}"/>
    <origin xyz="0 {2} 0.1"/><axis xyz="0 1 0"/><limit effort="20" velocity="20"/></joint>
"""
CASTER = """\
  <link name="{0}">{1}<collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="{0}_mount" type="fixed"><parent link="base_link"/><child link="{0}"/>
    <origin xyz="{2} 0 0.05"/></joint>
"""
UP = '<axis xyz="0 0 1"/><limit lower="-0.5" upper="0.5" effort="300" velocity="0.5"/>'
CRANE = f"""\
<robot name="crane">
  <link name="base_link">{MASS.format(30, 1)}
    <collision><origin xyz="0 0 0.2"/><geometry><box size="0.4 0.4 0.2"/></geometry></collision></link>
{WHEEL.format("l", MASS.format(1, 0.01), 0.3)}{WHEEL.format("r", MASS.format(1, 0.01), -0.3)}
{CASTER.format("front_caster", MASS.format(0.1, 0.001), 0.18)}
{CASTER.format("rear_caster", MASS.format(0.1, 0.001), -0.18)}
  <link name="mast">{MASS.format(2, 0.02)}{SOLID.format(0.1)}</link>
  <link name="boom">{MASS.format(2, 0.02)}{SOLID.format(0.1)}</link>
  <link name="hook"/>
  <link name="head">{MASS.format(1, 0.01).replace("<mass", '<origin xyz="0.1 0 0"/><mass')}</link>
  <joint name="lift" type="prismatic"><parent link="base_link"/><child link="mast"/>
    <origin xyz="0 0 0.25"/>{UP}</joint>
  <joint name="stage" type="prismatic"><parent link="mast"/><child link="boom"/>{UP}
    <mimic joint="lift" multiplier="0.5" offset="0.05"/></joint>
  <joint name="tip" type="fixed"><parent link="boom"/><child link="hook"/></joint>
  <joint name="nod" type="revolute"><parent link="mast"/><child link="head"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="20" velocity="1"/></joint>
</robot>
"""


@pytest.fixture
def backend(physics: type[PhysicsBackend], tmp_path: Path) -> Iterator[PhysicsBackend]:
    (tmp_path / "crane.urdf").write_text(CRANE, encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    made = physics(load_robot(str(tmp_path / "robot.yaml")), EMPTY, 0)
    yield made
    made.close()


def test_mimics_follow_held_things_stay_and_contacts_are_allowed(backend: Any) -> None:
    """The engine has the hand where kinematics has it, after the lift went up by 0.2 m."""
    arm = backend.get(Arm)
    for height in np.linspace(0.1, 0.3, 40):
        arm.move(np.array([height]))
        backend.step()
    for _ in range(20):
        arm.move(np.array([0.3]))
        backend.step()
    model = backend.scene.robot.arm_model()
    expected = backend.scene.world_T_base @ model.forward(np.array([0.3]))
    assert np.allclose(backend.link_pose("hand")[:3, 3], expected[:3, 3], atol=0.004)
    assert expected[2, 3] == pytest.approx(0.25 + 0.3 + 0.2, abs=0.01)
    head = backend.link_pose("head")[:3, :3]
    assert np.allclose(head, np.eye(3), atol=0.02)
