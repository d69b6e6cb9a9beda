"""Robots whose makers gave links and joints other names, with a lift, and with bodies that overlap."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.files.errors import FileError
from handcart.robotics.kinematics.urdf_contents import joints_of, link_names
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

ROBOT = """\
format: handcart-robot/1
urdf: lifter.urdf
srdf: lifter.srdf
links: {base: base_link, hand: tool0, imu: tool0}
allowed_contacts: [[base_link, tool0]]
period_s: 0.05
footprint_radius_m: 0.3
localizer: odometry
drive: {left: wheel_l_joint, right: [wheel_r1_joint, wheel_r2_joint], wheel_radius_m: 0.1, tread_m: 0.5,
        top_speed_m_s: 0.5, top_turn_deg_s: 90, acceleration_m_s2: 0.5, turn_acceleration_deg_s2: 90}
arm:
  joints: [lift, turn]
  top_speed_deg_s: 90
  acceleration_deg_s2: 180
  slide_speed_mm_s: 50
  slide_acceleration_mm_s2: 100
  postures: {home: [250, 190]}
tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, slides_mm: 3, gripper_mm: 1, object_mm: 8}
"""
SOLID = '<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
WHEEL = '<joint name="{0}_joint" type="continuous"><parent link="base_link"/><child link="{0}"/></joint>'
LIFTER = f"""\
<robot name="lifter">
  <link name="base_link">{SOLID}</link><link name="carriage">{SOLID}</link><link name="tool0">{SOLID}</link>
  <link name="wheel_l"/><link name="wheel_r1"/><link name="wheel_r2"/>
  <joint name="lift" type="prismatic"><parent link="base_link"/><child link="carriage"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.3" effort="50" velocity="0.1"/></joint>
  <joint name="turn" type="continuous"><parent link="carriage"/><child link="tool0"/><axis xyz="0 0 1"/>
    <limit effort="5" velocity="1"/></joint>
  {WHEEL.format("wheel_l")}{WHEEL.format("wheel_r1")}{WHEEL.format("wheel_r2")}
</robot>
"""
SRDF = '<robot name="lifter"><disable_collisions link1="carriage" link2="tool0" reason="Adjacent"/></robot>'


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "lifter.urdf").write_text(LIFTER, encoding="utf-8")
    (tmp_path / "lifter.srdf").write_text(SRDF, encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    return tmp_path / "robot.yaml"


def changed(file: Path, old: str, new: str) -> str:
    """Return the findings on the robot with that change in its file."""
    assert old in ROBOT
    file.write_text(ROBOT.replace(old, new), encoding="utf-8")
    with pytest.raises(FileError) as error:
        load_robot(str(file))
    return str(error.value)


def test_links_and_joints_are_mapped(file: Path) -> None:
    urdf = load_robot(str(file)).urdf_text()
    assert {"base", "hand", "imu", "left_wheel", "right_1_wheel", "right_2_wheel"} <= set(link_names(urdf))
    assert driven_wheels(item.name for item in joints_of(urdf)).right == ("right_1_wheel", "right_2_wheel")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("hand: tool0", "hand: tol0", "robot.yaml:4:32: the URDF has no link 'tol0'; did you mean 'tool0'?"),
        ("base: base_link, ", "", "the URDF has no link 'base'; did you mean 'base_link'?"),
        ("left: wheel_l_joint", "left: wheel_joint", "the URDF has no joint 'wheel_joint'; did you mean"),
        ("links: {base", "links: {bass", "bass"),
    ],
)
def test_what_is_mapped_must_be_there(file: Path, old: str, new: str, words: str) -> None:
    assert words in changed(file, old, new)


def test_a_lift_is_entered_in_mm_and_an_endless_joint_within_a_turn(file: Path) -> None:
    robot = load_robot(str(file))
    assert robot.posture("home") == pytest.approx((0.25, math.radians(-170.0)))
    assert robot.joint_speeds().tolist() == pytest.approx([0.05, math.radians(90.0)])
    assert robot.joint_accelerations().tolist() == pytest.approx([0.1, math.radians(180.0)])
    assert robot.joint_units.user_units(robot.posture("home")) == pytest.approx((250.0, -170.0))
    assert robot.joint_units.words(0, 0.1234) == "123.4 mm"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("home: [250, 190]", "home: [350, 0]", "lift can't stand at 350 mm; allowed: 0.0 to 300.0"),
        ("home: [250, 190]", "home: [250]", "1 angles; allowed: 2, one for each joint (mm, deg)"),
        ("  slide_speed_mm_s: 50\n", "", "the joint 'lift' slides; needed: slide_speed_mm_s"),
        (
            "  slide_acceleration_mm_s2: 100\n",
            "",
            "the joint 'lift' slides; needed: slide_acceleration_mm_s2",
        ),
        ("arm:\n", "arm:\n  working_deg: {lift: [0, 1]}\n", "'lift' doesn't turn; allowed: joints that do"),
        ("[lift, turn]", "[lift, trun]", "the URDF has no movable joint 'trun'; did you mean 'turn'?"),
        ("[lift, turn]", "[lift, lift]", "'lift' stands there 2 times; allowed: each joint once"),
        ("[lift, turn]", "[]", "an arm without joints"),
    ],
)
def test_what_a_lift_cannot_do_is_told_in_its_unit(file: Path, old: str, new: str, words: str) -> None:
    assert words in changed(file, old, new)


def test_allowed_contacts_are_those_of_the_srdf_and_of_the_file(file: Path) -> None:
    robot = load_robot(str(file))
    assert robot.whole.allowed == {("carriage", "hand"), ("base", "hand")}
    q = np.array(robot.posture("home"))
    assert CollisionModel(robot.arm_model()).contacts(0.0 * q) == []
    file.write_text(ROBOT.replace("allowed_contacts: [[base_link, tool0]]\n", ""), encoding="utf-8")
    stricter = load_robot(str(file)).arm_model()
    assert CollisionModel(stricter).contacts(0.0 * q) == [("base", "hand")]
    assert CollisionModel(stricter.with_others({})).contacts(0.0 * q) == [("base", "hand")]


@pytest.mark.parametrize(
    ("srdf", "words"),
    [
        ("<robot><disable_collisions link1='a'/></robot>", "lifter.srdf:1:8: a <disable_collisions> names n"),
        ("<robit/>", "lifter.srdf:1:1: the SRDF's root is <robit>; allowed: <robot>"),
        ("<robot>", "lifter.srdf:1:8: the file is not well-formed"),
    ],
)  # fmt: skip
def test_a_wrong_srdf_is_told_at_its_line(file: Path, srdf: str, words: str) -> None:
    (file.parent / "lifter.srdf").write_text(srdf, encoding="utf-8")
    assert words in changed(file, "home: [250, 190]", "home: [250, 190]")


def test_a_missing_srdf_is_told(file: Path) -> None:
    assert "robot.yaml:3:7: missing text file 'other.srdf'" in changed(file, "srdf: lifter", "srdf: other")


def test_the_urdf_of_an_installed_package_stands_at_the_top_too(file: Path) -> None:
    wrong = changed(file, "urdf: lifter.urdf", 'urdf: "package://no_such_shop/lifter.urdf"')
    assert "robot.yaml:2:7: missing package 'no_such_shop'" in wrong
    text = ROBOT.replace(
        "urdf: lifter.urdf", 'urdf: "package://handcart/backends/robots/librarian/librarian.urdf"'
    )
    file.write_text(text, encoding="utf-8")
    with pytest.raises(FileError, match="the URDF has no link 'base_link'"):
        load_robot(str(file))
