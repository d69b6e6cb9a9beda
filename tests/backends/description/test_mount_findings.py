"""Cameras behind joints that nothing reads, and other sensors that the arm carries, are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from tests.small_robot import LIFTING_ROBOT

URDF = """\
<robot name="r">
  <link name="base"/><link name="carriage"/><link name="hand"/><link name="sensor"/>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="carriage"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.3" effort="50" velocity="0.1"/></joint>
  <joint name="turn" type="continuous"><parent link="carriage"/><child link="hand"/></joint>
  <joint name="mount" type="{kind}"><parent link="{onto}"/><child link="sensor"/>{more}</joint>
</robot>
"""
CAMERA = "camera: {width_px: 640, height_px: 480, focal_px: 600}\nlinks: {camera: sensor}\n"
RANGE = "range_sensor: {beams: 90, reach_m: 8, sigma_mm: 10}\nlinks: {range_sensor: sensor}\n"
FOLLOWS = '<mimic joint="turn"/>'


def findings_of(tmp_path: Path, section: str, onto: str, kind: str = "fixed", more: str = "") -> str:
    """Return the findings on a robot with that sensor on one of its links; empty if there are none."""
    (tmp_path / "robot.urdf").write_text(URDF.format(onto=onto, kind=kind, more=more), encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(LIFTING_ROBOT + section, encoding="utf-8")
    try:
        load_robot(str(tmp_path / "robot.yaml"))
    except FileError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    ("onto", "kind"),
    [("hand", "continuous"), ("base", "continuous"), ("carriage", "prismatic")],
)
def test_camera_behind_a_joint_that_nothing_reads_is_refused(tmp_path: Path, onto: str, kind: str) -> None:
    limit = '<limit lower="0" upper="1" effort="1" velocity="1"/>'
    words = findings_of(tmp_path, CAMERA, onto, kind, limit)
    urdf = f"{tmp_path}/robot.urdf:6"
    assert f"{tmp_path}/robot.yaml:12:17: the joint 'mount' ({urdf}) is between the links `base`" in words
    assert "and nothing reads it; allowed: a sensor behind joints of the section `arm` only" in words
    assert words.count(".urdf:") == 1


@pytest.mark.parametrize(
    ("onto", "kind", "more"),
    [
        ("hand", "fixed", ""),
        ("carriage", "fixed", ""),
        ("base", "fixed", ""),
        ("base", "continuous", FOLLOWS),
    ],
)
def test_camera_behind_the_arms_own_joints_is_accepted(
    tmp_path: Path, onto: str, kind: str, more: str
) -> None:
    assert findings_of(tmp_path, CAMERA, onto, kind, more) == ""


@pytest.mark.parametrize(
    ("onto", "kind", "more", "refused"),
    [
        ("carriage", "fixed", "", True),
        ("base", "continuous", FOLLOWS, True),
        ("base", "continuous", "", False),
        ("base", "fixed", "", False),
    ],
)
def test_range_sensor_is_refused_where_the_arm_moves_it(
    tmp_path: Path, onto: str, kind: str, more: str, refused: bool
) -> None:
    """A joint that nothing moves stays at zero, and may carry it."""
    words = findings_of(tmp_path, RANGE, onto, kind, more)
    assert ("allowed: one fixed on the base" in words) is refused
