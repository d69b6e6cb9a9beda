"""The librarian with its camera on a head that pans and tilts, in place of that on its hand."""

from __future__ import annotations

import shutil
from pathlib import Path

import yaml

from handcart.backends.description.robot_names import robot_path

HEAD = """\
<robot name="head">
  <link name="head_mount"/>
  <link name="neck"/>
  <link name="head"><collision><geometry><box size="0.08 0.12 0.08"/></geometry></collision>
    <inertial><mass value="0.5"/>
      <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>
  </link>
  <link name="eye"/>
  <joint name="pan" type="revolute"><parent link="head_mount"/><child link="neck"/><axis xyz="0 0 1"/>
    <limit lower="-1.5" upper="1.5" effort="5" velocity="2"/></joint>
  <joint name="tilt" type="revolute"><parent link="neck"/><child link="head"/><axis xyz="0 1 0"/>
    <limit lower="-0.8" upper="1.4" effort="5" velocity="2"/></joint>
  <joint name="eye_mount" type="fixed"><parent link="head"/><child link="eye"/>
    <origin xyz="0.05 0 0" rpy="-1.570796327 0 -1.570796327"/></joint>
</robot>
"""
HEAD_JOINTS = ["pan", "tilt"]


def head_robot(folder: Path, height: float = 1.35) -> Path:
    """Return the robot's file; its head is so high above the floor, in [m]."""
    folder.mkdir(exist_ok=True)
    source = robot_path("librarian")
    shutil.copy(source.parent / "librarian.urdf", folder)
    (folder / "head.urdf").write_text(HEAD, encoding="utf-8")
    content = yaml.safe_load(source.read_text(encoding="utf-8"))
    content["parts"] = [{"urdf": "head.urdf", "onto": "base", "xyz_m": [0.15, 0.3, height]}]
    content["links"] = {"camera": "eye"}
    arm = content["arm"]
    arm["joints"] = [*HEAD_JOINTS, *arm["joints"]]
    arm["postures"] = {name: [0, 30, *angles] for name, angles in arm["postures"].items()}
    content["can"] = content["ros2"] = None
    file = folder / "robot.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    return file
