"""Robots put together from several URDFs."""

from __future__ import annotations

from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.urdf import robot_parts
from handcart.files.errors import FileError
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Hull
from handcart.robotics.kinematics.urdf_contents import joints_of, link_names
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.kinematics.urdf_pruning import without_joints

ROBOT = """\
format: handcart-robot/1
urdf: cart.urdf
parts:
  - {urdf: stick.urdf, onto: base, xyz_m: [0.1, 0.0, 0.5], rpy_deg: [0.0, 0.0, 90.0]}
  - {urdf: stick.urdf, onto: stick_end, prefix: upper_}
period_s: 0.05
footprint_radius_m: 0.3
localizer: odometry
drive: {wheel_radius_m: 0.1, tread_m: 0.5, top_speed_m_s: 0.5, top_turn_deg_s: 90, acceleration_m_s2: 0.5,
        turn_acceleration_deg_s2: 90}
tolerance: {base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}
"""
CART = "<robot name='cart'><link name='base'/></robot>"
STICK = """\
<robot name="stick">
  <link name="stick"><collision><geometry><mesh filename="package://stick_shop/solid.obj"/></geometry></collision></link>
  <link name="stick_end"/>
  <joint name="turn" type="revolute">
    <parent link="stick"/><child link="stick_end"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/>
  </joint>
</robot>
"""
HALF = 2**-0.5
CORNERS = [(x, y, z) for x in (0.0, 0.2) for y in (0.0, 0.04) for z in (0.0, 0.02)]
FACES = "1 3 4 2|5 6 8 7|1 2 6 5|3 7 8 4|1 5 7 3|2 4 8 6"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A stick on a stick on a cart; the mesh lies in a package beside the URDF."""
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    (tmp_path / "stick_shop").mkdir()
    faces = "".join(f"f {face}\n" for face in FACES.split("|"))
    (tmp_path / "stick_shop" / "solid.obj").write_text(corners + faces, encoding="utf-8")
    (tmp_path / "cart.urdf").write_text(CART, encoding="utf-8")
    (tmp_path / "stick.urdf").write_text(STICK, encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    return tmp_path / "robot.yaml"


def error_of(path: Path) -> str:
    """Return the findings on a faulty robot."""
    with pytest.raises(FileError) as error:
        load_robot(str(path))
    return str(error.value)


def test_parts_stand_where_the_file_says(robot: Path) -> None:
    urdf = load_robot(str(robot)).urdf_text()
    assert link_names(urdf) == ["base", "stick", "stick_end", "upper_stick", "upper_stick_end"]
    arm = ArmModel(urdf, ["turn", "upper_turn"], tip="upper_stick_end")
    straight = arm.forward(np.zeros(2))
    assert np.allclose(straight[:3, 3], (0.1, 0.4, 0.5))
    assert np.allclose(arm.forward(np.array([-np.pi / 2, 0.0]))[:3, 3], (0.3, 0.2, 0.5))


def test_a_mesh_counts_as_its_hull(robot: Path) -> None:
    arm = ArmModel(load_robot(str(robot)).urdf_text(), ["turn", "upper_turn"], tip="upper_stick_end")
    lower, _ = arm.link_shapes(np.zeros(2))
    assert isinstance(lower, Hull)
    assert lower.name == "stick"
    corners = lower.points @ lower.pose[:3, :3].T + lower.pose[:3, 3]
    assert np.allclose(corners.min(axis=0), (0.06, 0.0, 0.5))
    assert np.allclose(corners.max(axis=0), (0.1, 0.2, 0.52))


@pytest.mark.parametrize(
    ("old", "new", "wrong"),
    [
        (", prefix: upper_", "", "robot.yaml:5:5: both have a link 'stick'; allowed: a prefix"),
        ("onto: base", "onto: bass", "robot.yaml:4:5: unknown link 'bass' to put it onto; allowed: base"),
        ("urdf: stick", "urdf: stock", "robot.yaml:4:5: missing text file 'stock.urdf'"),
        (
            "urdf: stick.urdf",
            'urdf: "package://no_such_shop/stick.urdf"',
            "robot.yaml:4:5: missing package 'no_such_shop'",
        ),
        ("urdf: stick.urdf", 'urdf: "package://../stick.urdf"', "names no package"),
        ("urdf: stick.urdf", "urdf: ../stick.urdf", "leads out of"),
        ("urdf: stick.urdf", "urdf: robot.yaml", "robot.yaml:1:1: the file is not well-formed"),
    ],
)
def test_a_wrong_part_is_told_with_its_place(robot: Path, old: str, new: str, wrong: str) -> None:
    robot.write_text(ROBOT.replace(old, new, 1), encoding="utf-8")
    assert wrong in error_of(robot)


def test_a_missing_collision_mesh_is_told(robot: Path) -> None:
    (robot.parent / "stick_shop" / "solid.obj").unlink()
    said = error_of(robot)
    assert "stick.urdf:2:43: link 'stick': mesh 'package://stick_shop/solid.obj': it isn't there" in said


@pytest.mark.parametrize(("there", "meant"), [("Solid.OBJ", "Solid.OBJ"), ("sold.obj", "sold.obj")])
def test_mesh_spelled_otherwise_is_named(robot: Path, there: str, meant: str) -> None:
    shop = robot.parent / "stick_shop"
    (shop / "solid.obj").rename(shop / there)
    assert f"solid.obj': it isn't there; did you mean {meant!r}? allowed: a file" in error_of(robot)


def test_a_mesh_without_volume_is_told(robot: Path) -> None:
    (robot.parent / "stick_shop" / "solid.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "utf-8")
    said = error_of(robot)
    assert "stick.urdf:2:43: link 'stick'" in said
    assert "it encloses nothing; allowed: a closed surface" in said


@pytest.mark.parametrize(
    ("link", "key"), [("camera", "camera"), ("range_sensor", "range_sensor"), ("hand", "arm")]
)
def test_a_missing_frame_is_told(tmp_path: Path, link: str, key: str) -> None:
    """S8: before anything moves."""
    source = load_robot("librarian").folder
    urdf = (source / "librarian.urdf").read_text(encoding="utf-8")
    renamed = urdf.replace(f'link name="{link}"', f'link name="other_{link}"')
    renamed = renamed.replace(f'link="{link}"', f'link="other_{link}"')
    (tmp_path / "librarian.urdf").write_text(renamed, encoding="utf-8")
    (tmp_path / "robot.yaml").write_bytes((source / "robot.yaml").read_bytes())
    assert f"the URDF has no link '{link}'" in error_of(tmp_path / "robot.yaml")


def test_fingers_must_tell_their_size(tmp_path: Path) -> None:
    source = load_robot("librarian").folder
    urdf = (source / "librarian.urdf").read_text(encoding="utf-8")
    solid = '<origin xyz="0.095 0.00075 0"/><geometry><box size="0.11 0.0015 0.04"/></geometry>'
    box = f"<collision>{solid}</collision>"
    assert box in urdf
    (tmp_path / "librarian.urdf").write_text(urdf.replace(box, ""), encoding="utf-8")
    (tmp_path / "robot.yaml").write_bytes((source / "robot.yaml").read_bytes())
    assert "the link 'left_finger' has no collision box" in error_of(tmp_path / "robot.yaml")


def test_joints_are_left_out_with_all_that_they_carry(robot: Path) -> None:
    robot.write_text(ROBOT.replace("onto: stick_end,", "onto: stick_end, without: [turn],"), encoding="utf-8")
    names = link_names(load_robot(str(robot)).urdf_text())
    assert "stick_end" in names and "upper_stick" in names and "upper_stick_end" not in names


def test_joint_to_leave_out_that_is_missing_is_named(robot: Path) -> None:
    robot.write_text(ROBOT.replace("onto: stick_end,", "onto: stick_end, without: [trun],"), encoding="utf-8")
    words = error_of(robot)
    assert ":5:51: stick.urdf has no joint 'trun'; did you mean 'turn'?" in words


def test_faults_of_what_is_left_out_do_not_count(robot: Path) -> None:
    broken = STICK.replace('lower="-1"', 'lower="$(optenv LOW -1)"')
    (robot.parent / "stick.urdf").write_text(broken, encoding="utf-8")
    assert "an expression of xacro" in error_of(robot)
    both = ROBOT.replace("onto: base,", "onto: base, without: [turn],").replace("stick_end", "stick")
    robot.write_text(both.replace("onto: stick,", "onto: stick, without: [turn],"), encoding="utf-8")
    assert "upper_stick" in link_names(load_robot(str(robot)).urdf_text())


def test_still_joints_hold_their_position(robot: Path) -> None:
    robot.write_text(f"{ROBOT}still: {{turn: 45}}\n", encoding="utf-8")
    loaded = load_robot(str(robot))
    assert [item.name for item in joints_of(loaded.urdf_text())] == ["upper_turn"]
    stick = base_T_frame(loaded.urdf_text(), "upper_stick")
    assert np.allclose(stick[:2, :2], [[-HALF, -HALF], [HALF, -HALF]])  # 90 deg by the part, 45 by the joint


@pytest.mark.parametrize(
    ("still", "words"),
    [
        ("{trun: 3}", ":12:15: the URDF has no movable joint 'trun'; did you mean 'turn'?"),
        ("{turn: 70}", ":12:15: 'turn' can't stand at 70 deg; allowed: -57.3 to 57.3 deg"),
    ],
)
def test_still_joints_that_cannot_be_so_are_named(robot: Path, still: str, words: str) -> None:
    robot.write_text(f"{ROBOT}still: {still}\n", encoding="utf-8")
    assert words in error_of(robot)


def test_missing_package_comes_with_the_command_that_installs_it(robot: Path) -> None:
    text = ROBOT.replace("urdf: cart.urdf", "urdf: package://example-robot-data/robots/a.urdf")
    robot.write_text(text, encoding="utf-8")
    with patch.object(robot_parts, "package_folders", return_value=iter(())):
        words = error_of(robot)
    assert words.startswith(f"{robot}:2:7: missing package 'example-robot-data'")
    assert words.endswith("pip install 'handcart[robots]'")


def test_all_links_behind_a_joint_are_left_out() -> None:
    links = "".join(f'<link name="{name}"/>' for name in "abcd")
    joints = "".join(
        f'<joint name="{a}{b}" type="fixed"><parent link="{a}"/><child link="{b}"/></joint>'
        for a, b in ("cd", "bc", "ab")
    )
    assert link_names(without_joints(f"<robot name='chain'>{links}{joints}</robot>", ["ab"])) == ["a"]
