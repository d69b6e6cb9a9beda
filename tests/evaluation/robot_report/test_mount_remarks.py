"""Remarks of `check` about the lidar's mounting and about the ground contact of the base."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.robot_report.mount_remarks import (
    hidden_links,
    hidden_sector,
    mount_remarks,
    whole_degrees,
)

LIDAR = '<origin xyz="0 0 0.25"/>'
MAST = """<link name="mast"><collision><origin xyz="-0.2 0 0.3"/>
  <geometry><box size="0.04 0.04 0.4"/></geometry>
  </collision></link>
  <joint name="mast" type="fixed"><parent link="base"/><child link="mast"/></joint></robot>"""


def cart(folder: Path, old: str = "", new: str = "", keys: str = "") -> list[str]:
    """The remarks on a cart with another URDF, and further keys of its lidar."""
    for file in robot_path("cart").parent.glob("*.*"):
        shutil.copy(file, folder)
    urdf, robot = folder / "cart.urdf", folder / "robot.yaml"
    assert old in urdf.read_text(encoding="utf-8")
    urdf.write_text(urdf.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    text = robot.read_text(encoding="utf-8").replace("reach_m: 12.0", f"reach_m: 12.0{keys}")
    robot.write_text(text, encoding="utf-8")
    return [str(remark) for remark in mount_remarks(load_robot(str(robot)))]


@pytest.mark.parametrize(
    ("origin", "words"),
    [
        ('<origin xyz="0 0 -0.1"/>', "the lidar is 0.100 m below the floor"),
        ('<origin xyz="0 0 0"/>', "the lidar is 0.000 m above the floor"),
        ('<origin xyz="0 0 0.1"/>', "inside a collision body of the link 'base'"),
        ('<origin xyz="0 0 0.25" rpy="3.14159265 0 0"/>', "mounted upside down"),
        ('<origin xyz="0 0 0.25" rpy="0 0.2 0"/>', "plane is tilted by 11 deg"),
    ],
)
def test_a_lidar_mounted_where_it_sees_nothing_is_told(tmp_path: Path, origin: str, words: str) -> None:
    found = cart(tmp_path, LIDAR, origin)
    assert any(words in remark for remark in found)
    assert all(re.match(r".*cart\.urdf:\d+:\d+: link 'range_sensor': ", remark) for remark in found)


def test_what_hides_the_view_is_told_until_it_is_masked(tmp_path: Path) -> None:
    (found,) = cart(tmp_path, "</robot>", MAST)
    assert "sees the link 'mast' of the robot itself from 173 to 187 deg" in found
    assert "masked_deg: [[173, -173]]" in found
    again = tmp_path / "again"
    again.mkdir()
    assert cart(again, "</robot>", MAST, "\n  masked_deg: [[173, -173]]") == []


def test_a_lidar_upside_down_is_masked_by_its_upright_angles(tmp_path: Path) -> None:
    """The file's angles are counter-clockwise from above, however the lidar is mounted."""
    aside = MAST.replace("-0.2 0 0.3", "0 0.2 0.3")  # to the left
    (upright,) = cart(tmp_path, "</robot>", aside)
    assert "masked_deg: [[83, 97]]" in upright
    file = tmp_path / "cart.urdf"
    text = file.read_text(encoding="utf-8").replace(LIDAR, '<origin xyz="0 0 0.25" rpy="3.14159265 0 0"/>')
    file.write_text(text, encoding="utf-8")
    robot = load_robot(str(tmp_path / "robot.yaml"))
    assert any("masked_deg: [[83, 97]]" in str(remark) for remark in mount_remarks(robot))
    assert [whole_degrees(sector) for _, sector in hidden_links(robot)] == [(83, 97)]


def test_a_base_without_casters_tips(tmp_path: Path) -> None:
    assert cart(tmp_path) == []
    other = tmp_path / "other"
    other.mkdir()
    (found,) = cart(other, "0.27 0 0.03", "0.27 0 0.1")  # the front and, by its sign, the rear caster
    assert "with physics it tips" in found


@given(st.floats(-math.pi, math.pi), st.floats(0.3, 3.0), st.integers(3, 9))
def test_an_outline_hides_the_bearings_of_its_points(direction: float, far: float, corners: int) -> None:
    around = np.linspace(0.0, 2.0 * math.pi, corners, endpoint=False)
    outline = 0.2 * np.column_stack([np.cos(around), np.sin(around)])
    assert hidden_sector(outline) is None
    seen = outline + far * np.array([math.cos(direction), math.sin(direction)])
    sector = hidden_sector(seen)
    assert sector is not None
    assert sector[1] - sector[0] <= 2.0 * math.asin(0.2 / far) + 1e-9
    bearings = np.arctan2(seen[:, 1], seen[:, 0])
    within = np.mod(bearings - sector[0] + 1e-9, 2.0 * math.pi) <= sector[1] - sector[0] + 2e-9
    assert within.all()
