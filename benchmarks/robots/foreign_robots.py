"""The robots of `foreign`: where packages from PyPI have them, and what their user adds to the draft."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

LIDAR_URDF = "<robot name='lidar'><link name='lidar_frame'/></robot>\n"
BASE_URDF = """\
<robot name="base_of_our_own">
  <link name="base"/>
  <link name="body">
    <inertial><origin xyz="0 0 0.25"/><mass value="40"/>
      <inertia ixx="1.2" ixy="0" ixz="0" iyy="1.2" iyz="0" izz="1.8"/></inertial>
    <collision><origin xyz="0 0 0.25"/><geometry><box size="0.5 0.36 0.34"/></geometry></collision>
  </link>
  <joint name="body_joint" type="fixed"><parent link="base"/><child link="body"/></joint>
  {wheels}
</robot>
"""
WHEEL_URDF = """\
  <link name="{side}_wheel">
    <inertial><mass value="1"/>
      <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.006" iyz="0" izz="0.004"/></inertial>
    <collision><origin rpy="1.570796 0 0"/>
      <geometry><cylinder radius="0.1" length="0.04"/></geometry></collision>
  </link>
  <joint name="{side}_wheel" type="continuous"><parent link="body"/><child link="{side}_wheel"/>
    <origin xyz="0 {y} 0.1"/><axis xyz="0 1 0"/></joint>
"""
CASTER_URDF = """\
  <link name="{end}_caster">
    <inertial><mass value="0.3"/>
      <inertia ixx="2e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="2e-4"/></inertial>
    <collision><geometry><sphere radius="0.03"/></geometry></collision>
  </link>
  <joint name="{end}_caster" type="fixed"><parent link="body"/><child link="{end}_caster"/>
    <origin xyz="{x} 0 0.03"/></joint>
"""
Overlay = Mapping[str, Any]


class NotThere(Exception):
    """A package doesn't hold the robot, or isn't installed."""


class ForeignRobot(NamedTuple):
    """A robot of a package."""

    name: str
    package: str
    """That pip installs it with."""
    collect: Callable[[Path, Path], Path]
    """Copies its files from a folder of packages into another one; returns the URDF to draft a robot from."""
    overlay: Overlay
    """Edits of its user to the draft: merged key by key, None removes a key."""


def _copied(packages: Path, into: Path, *inside: str) -> Path:
    """Copy the folder that ends in a path, from whichever package has it; keep that path."""
    for folder in _folders(packages, inside[0]):
        for name in inside:
            source, goal = folder / name, into / Path(folder.name) / name
            goal.parent.mkdir(parents=True, exist_ok=True)
            shutil.copytree(source, goal, dirs_exist_ok=True)
        return into / folder.name
    raise NotThere(f"no folder {inside[0]} below {packages}")


def _folders(packages: Path, inside: str) -> Iterator[Path]:
    """Folders that hold a path, in packages that were installed there with `pip install --target`."""
    roots = [packages, *sorted(packages.glob("*"))]
    below = ("", "cmeel.prefix/share/example-robot-data", "stretch_urdf", "pybullet_data")
    yield from (root / name for root in roots for name in below if (root / name / inside).is_dir())
    spec = find_spec("pybullet_data")
    for place in (spec.submodule_search_locations or ()) if spec else ():
        if (Path(place) / inside).is_dir():
            yield Path(place)


def _data(description: str, urdf: str) -> Callable[[Path, Path], Path]:
    """Return a function that collects a URDF of example-robot-data."""

    def collect(packages: Path, into: Path) -> Path:
        return _copied(packages, into, f"robots/{description}") / "robots" / description / urdf

    return collect


def _stretch(model: str, urdf: str) -> Callable[[Path, Path], Path]:
    def collect(packages: Path, into: Path) -> Path:
        return _copied(packages, into, model) / model / urdf

    return collect


def _husky(packages: Path, into: Path) -> Path:
    """Return the husky that comes with PyBullet: xacro has left `$(optenv NAME VALUE)`; the UR5 is put onto
    it.
    """
    urdf = _copied(packages, into, "husky") / "husky" / "husky.urdf"
    urdf.write_text(re.sub(r"\$\(optenv \w+ ([^)]*)\)", r"\1", urdf.read_text()), encoding="utf-8")
    _data("ur_description", "urdf/ur5_robot.urdf")(packages, into)
    return urdf


def _kinova(packages: Path, into: Path) -> Path:
    sides = "".join(WHEEL_URDF.format(side=side, y=y) for side, y in (("left", 0.21), ("right", -0.21)))
    ends = "".join(CASTER_URDF.format(end=end, x=x) for end, x in (("front", 0.21), ("rear", -0.21)))
    (into / "base.urdf").write_text(BASE_URDF.format(wheels=sides + ends), encoding="utf-8")
    _data("kinova_description", "robots/kinova.urdf")(packages, into)
    return into / "base.urdf"


def _with_lidar(height: float, x: float = 0.0) -> dict[str, Any]:
    """Return a range sensor of one's own, on the link that carries all."""
    return {"urdf": "lidar.urdf", "xyz_m": [x, 0.0, height]}


_LIDAR: Overlay = {
    "localizer": "scan",
    "range_sensor": {"beams": 360, "reach_m": 8.0, "sigma_mm": 10},
    "errors": {"wheel_radius_percent": 0.2, "tread_percent": 0.5, "slip_percent": 1.0},
}
_DATA = "example-robot-data"
_STRETCH = "hello-robot-stretch-urdf"
_UR5 = [
    f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
]
_JACO = [f"j2s6s200_joint_{number}" for number in range(1, 7)]

_FOLDED = [-63, 84, 155, 98, -90, 78, 0]


def _both_arms() -> list[str]:
    return [f"arm_{side}_{number}_joint" for side in ("left", "right") for number in range(1, 8)]


FOREIGN_ROBOTS = (
    ForeignRobot(
        "tiago",
        _DATA,
        _data("tiago_description", "robots/tiago.urdf"),
        {
            **_LIDAR,
            "links": {"range_sensor": "lidar_frame"},
            "parts": [{**_with_lidar(0.1, 0.2), "onto": "base_footprint"}],
            "footprint_radius_m": 0.45,
            "arm": {"postures": {"home": [150, 11, -77, -11, 111, -90, 78, 0]}},
        },
    ),
    ForeignRobot(
        "tiago_dual",
        _DATA,
        _data("tiago_description", "robots/tiago_dual.urdf"),
        {
            **_LIDAR,
            "links": {"range_sensor": "lidar_frame"},
            "parts": [{**_with_lidar(0.1, 0.2), "onto": "base_footprint"}],
            "footprint_radius_m": 0.45,
            "arm": {
                "joints": ["torso_lift_joint", *_both_arms()],
                "postures": {"home": [150, *_FOLDED, *_FOLDED]},
            },
        },
    ),
    ForeignRobot(
        "husky_ur5",
        f"pybullet, {_DATA}",
        _husky,
        {
            **_LIDAR,
            "links": {"hand": "ur5_ee_link", "range_sensor": "lidar_frame"},
            "parts": [
                {
                    "urdf": "example-robot-data/robots/ur_description/urdf/ur5_robot.urdf",
                    "onto": "base_footprint",
                    "prefix": "ur5_",
                    "xyz_m": [0.25, 0.0, 0.42],
                },
                {**_with_lidar(0.3, 0.4), "onto": "base_footprint"},
            ],
            "footprint_radius_m": 0.62,
            "arm": {
                "joints": [f"ur5_{name}" for name in _UR5],
                "top_speed_deg_s": 30,
                "acceleration_deg_s2": 60,
                "postures": {"home": [0, -170, 150, -70, -90, 0]},
            },
        },
    ),
    ForeignRobot(
        "stretch_re2",
        _STRETCH,
        _stretch("RE2V0", "stretch_description_RE2V0_tool_stretch_gripper.urdf"),
        {
            **_LIDAR,
            "links": {"range_sensor": "laser"},
            "footprint_radius_m": 0.4,
            "arm": {"postures": {"home": [300, 0, 0, 0, 0, 180]}},
        },
    ),
    ForeignRobot(
        "stretch_se3",
        _STRETCH,
        _stretch("SE3", "stretch_description_SE3_eoa_wrist_dw3_tool_sg3.urdf"),
        {
            **_LIDAR,
            "links": {"range_sensor": "laser"},
            "footprint_radius_m": 0.4,
            "arm": {"postures": {"home": [300, 0, 0, 0, 0, 180, 0, 0]}},
        },
    ),
    ForeignRobot(
        "kinova",
        _DATA,
        _kinova,
        {
            **_LIDAR,
            "links": {"base": "base", "hand": "arm_j2s6s200_end_effector", "range_sensor": "lidar_frame"},
            "parts": [
                {
                    "urdf": "example-robot-data/robots/kinova_description/robots/kinova.urdf",
                    "onto": "base",
                    "prefix": "arm_",
                    "xyz_m": [0.1, 0.0, 0.42],
                },
                {**_with_lidar(0.15, 0.2), "onto": "base"},
            ],
            "footprint_radius_m": 0.4,
            "arm": {
                "joints": [f"arm_{name}" for name in _JACO],
                "top_speed_deg_s": 30,
                "acceleration_deg_s2": 60,
                "postures": {"home": [0, 180, 60, 0, 60, 0]},
            },
        },
    ),
)
