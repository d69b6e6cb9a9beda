"""Faults of a URDF are reported with line and link or joint, before a library reads it."""

from __future__ import annotations

import pytest

from handcart.robotics.kinematics.urdf_faults import urdf_faults

URDF = """\
<robot name="r">
  <link name="base">
    <inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
  <link name="upper"><collision><geometry><cylinder radius="0.1" length="1"/></geometry></collision></link>
  <link name="fore"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 1" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/>
  </joint>
  <joint name="elbow" type="prismatic">
    <parent link="upper"/><child link="fore"/>
    <limit lower="-2" upper="2" effort="5" velocity="1"/><mimic joint="shoulder" multiplier="2"/>
  </joint>
</robot>
"""


def error_of(text: str) -> str:
    return "\n".join(f"{fault.line}: {fault.message}" for fault in urdf_faults(text))


def test_a_sound_urdf_is_without_fault() -> None:
    assert error_of(URDF) == ""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('link name="fore"', 'link name="upper"', "7: link 'upper': line 6 has one of that name"),
        ('link name="fore"', "link", "7: a link has no name"),
        ('joint name="elbow"', 'joint name="shoulder"', "12: joint 'shoulder': line 8 has one of that name"),
        ('type="revolute"', 'type="Revolute"', "8: joint 'shoulder': unknown type 'Revolute'; did you mean"),
        ('<parent link="base"/>', '<parent link="bass"/>', "9: joint 'shoulder': its parent 'bass' is not a"),
        ('<child link="upper"/>', "", "8: joint 'shoulder': it has no child link"),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', "9: joint 'shoulder': its axis has no direction"),
        ('<limit lower="-1"', '<limit lower="3"', "10: joint 'shoulder': its lower limit 3 is above its upp"),
        ('effort="5" velocity="1"/>\n', 'effort="5"/>\n', "10: joint 'shoulder': <limit> has no velocity"),
        (
            '<limit lower="-1" upper="1" effort="5" velocity="1"/>',
            "",
            "8: joint 'shoulder': a revolute joint without",
        ),
        ('joint="shoulder" mult', 'joint="elbow" mult', "14: joint 'elbow': it mimics itself, by way of 'el"),
        ('multiplier="2"', 'multiplier="two"', "14: joint 'elbow': mimic multiplier is 'two'; allowed: a fi"),
        ('<child link="fore"/>', '<child link="base"/>', "hangs on itself; allowed: a tree of links"),
        ('<child link="fore"/>', '<child link="upper"/>', "12: joint 'elbow': joint 'shoulder' moves the li"),
        ('value="2"', 'value="inf"', "3: link 'base': mass value is 'inf'; allowed: a finite number"),
        ('value="2"', 'value="2_0"', "3: link 'base': mass value is '2_0'; allowed: a finite number"),
        ('<mass value="2"/>', "", "3: link 'base': its inertial has no <mass>"),
        ('ixx="1" ', "", "3: link 'base': <inertia> has no ixx"),
        ('size="1 1 1"', 'size="1 1 -1"', "4: link 'base': box size is '1 1 -1'; allowed: 3 finite numbers"),
        ('radius="0.1"', 'radius="0"', "6: link 'upper': cylinder radius is '0'; allowed: a number above 0"),
        ("<box", "<bax", "4: link 'base': unknown geometry <bax>; did you mean 'box'?"),
        ('<geometry><box size="1 1 1"/></geometry>', "", "4: link 'base': a collision body has no geometry"),
        ('<box size="1 1 1"/>', '<mesh filename=" "/>', "4: link 'base': a mesh names no file"),
        ('<box size="1 1 1"/>', '<mesh filename="a.stl" scale="1 0 1"/>', "4: link 'base': mesh scale is '1"),
        ('xyz="0 0 1" rpy', 'xyz="0 0" rpy', "9: joint 'shoulder': origin xyz is '0 0'; allowed: 3 finite n"),
        ('rpy="0 0 0"', 'rpy="$(optenv RPY 0 0 0)"', "9: joint 'shoulder': origin rpy is '$(optenv RPY 0 0"),
        ("<robot ", '<robot xmlns:xacro="x" ', ""),
        ('  <link name="fore"/>', '<xacro:arm xmlns:xacro="x"/>', "7: <xacro:arm> is xacro, not yet URDF"),
        ("</robot>", '<link name="alone"/></robot>', "16: link 'alone': it hangs on no joint, and neither d"),
        ("</robot>", "", "17: the URDF is not well-formed: no element found"),
        ("robot", "model", "1: the URDF's root is <model>; allowed: <robot>"),
    ],
)  # fmt: skip
def test_a_fault_is_told_at_its_line(old: str, new: str, words: str) -> None:
    assert old in URDF
    said = error_of(URDF.replace(old, new))
    assert words in said
    assert bool(said) == bool(words)


def test_all_faults_are_told_at_once() -> None:
    wrong = URDF.replace('value="2"', 'value="nan"').replace('radius="0.1"', 'radius=""')
    assert [fault.line for fault in urdf_faults(wrong)] == [3, 6]


def test_a_joint_that_mimics_nothing_is_only_doubtful() -> None:
    (doubt,) = urdf_faults(URDF.replace('joint="shoulder" mult', 'joint="soulder" mult'))
    assert doubt.mild
    assert doubt.message.startswith(
        "joint 'elbow': it mimics 'soulder', which is no joint, and counts as free"
    )
    assert not any(fault.mild for fault in urdf_faults(URDF.replace('value="2"', 'value=""')))
