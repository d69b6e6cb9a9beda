"""The sensors in a robot's file: a table by name, and the older keys that hold one sensor each."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from tests.makers import every_robot
from tests.small_robot import SMALL_ROBOT

URDF = """\
<robot name="r">
  <link name="base"/><link name="laser"/><link name="rear"/><link name="mast"/>
  <joint name="a" type="fixed"><parent link="base"/><child link="laser"/><origin xyz="0.2 0 0.3"/></joint>
  <joint name="b" type="fixed"><parent link="base"/><child link="rear"/>
    <origin xyz="-0.2 0 0.3" rpy="0 0 3.1416"/></joint>
  <joint name="c" type="fixed"><parent link="base"/><child link="mast"/><origin xyz="0 0 1.2"/></joint>
</robot>
"""
TABLE = """\
sensors:
  front: {kind: lidar, frame: laser, beams: 90, reach_m: 8, sigma_mm: 10}
  rear: {kind: lidar, beams: 45, reach_m: 4, sigma_mm: 10, start_deg: -90, end_deg: 90}
  mast: {kind: camera, width_px: 64, height_px: 48, focal_px: 60}
  unit: {kind: imu, frame: base, angle_random_walk_deg_rt_s: 0.1, accelerometer_sigma_m_s2: 0.01}
"""
LIDAR = "{beams: 90, reach_m: 8, sigma_mm: 10, frame: laser}"


def read(folder: Path, sections: str) -> RobotFile:
    (folder / "robot.urdf").write_text(URDF, encoding="utf-8")
    (folder / "robot.yaml").write_text(SMALL_ROBOT + sections, encoding="utf-8")
    return load_robot(str(folder / "robot.yaml"))


def findings(folder: Path, sections: str) -> list[str]:
    """What is wrong, each without the folder: LINE:COLUMN: words."""
    with pytest.raises(FileError) as raised:
        read(folder, sections)
    return [str(finding).removeprefix(f"{folder}/robot.yaml:") for finding in raised.value.findings]


def test_table_has_several_sensors_of_a_kind_by_name(tmp_path: Path) -> None:
    robot = read(tmp_path, TABLE)
    assert list(robot.sensors) == ["front", "rear", "mast", "unit"]
    assert {name: spec.beams for name, spec in robot.all_of(RangeSpec).items()} == {"front": 90, "rear": 45}
    assert [robot.link_of(spec) for spec in robot.sensors.values()] == ["laser", "rear", "mast", "base"]
    assert robot.range_sensor is robot.sensors["front"]
    assert robot.camera is robot.sensors["mast"]
    assert robot.gps is None


def test_older_key_is_a_table_with_one_entry(tmp_path: Path) -> None:
    old = read(tmp_path, f"range_sensor: {LIDAR}\n")
    new = read(tmp_path, f"sensors: {{range_sensor: {LIDAR.replace('beams', 'kind: lidar, beams')}}}\n")
    assert old.sensors == new.sensors
    assert old.model_dump_json() == new.model_dump_json()
    assert old.lidar_link == "laser"


@pytest.mark.parametrize("name", every_robot(short=True))
def test_shipped_robots_sensors_are_called_like_their_keys(name: str) -> None:
    robot = load_robot(name)
    assert robot.sensors
    for sensor, spec in robot.sensors.items():
        assert getattr(robot, sensor) is spec
        assert robot.key_of(sensor) == (sensor,)


@pytest.mark.parametrize(
    ("sections", "wrong"),
    [
        (
            "sensors: {front: {kind: lidr, beams: 9}}\n",
            "9:25: kind is 'lidr'; did you mean 'lidar'? allowed: ",
        ),
        ("sensors: {front: {beams: 9}}\n", "9:18: the key 'kind' is missing; allowed: lidar, camera, "),
        (
            f"sensors: {{front: {LIDAR.replace('beams', 'kind: lidar, beems')}}}\n",
            "9:32: unknown key 'beems'; did you mean 'beams'?",
        ),
        ("range_senor: {beams: 9}\n", "9:1: unknown key 'range_senor'; did you mean 'range_sensor'?"),
        (
            f"range_sensor: {LIDAR.replace('laser', 'lasr')}\n",
            "9:60: the URDF has no link 'lasr'; did you mean 'laser'?",
        ),
        (
            "sensors:\n  scan: {kind: lidar, beams: 9, reach_m: 8, sigma_mm: 1}\n",
            "10:9: the URDF has no link 'scan'; allowed: base, laser, rear, mast; or name one of them as the "
            "sensor's `frame`",
        ),
        (
            "sensors: {9th: {kind: lidar, beams: 9, reach_m: 8, sigma_mm: 1}}\n",
            "9:11: the key '9th' does not fit; allowed: text like ",
        ),
        (
            f"range_sensor: {LIDAR}\n" + TABLE.replace("front", "range_sensor"),
            "two sensors are called 'range_sensor'; allowed: a name of its own for each",
        ),
    ],
)
def test_wrong_sensor_is_reported_at_its_place(tmp_path: Path, sections: str, wrong: str) -> None:
    assert any(wrong in finding for finding in findings(tmp_path, sections)), findings(tmp_path, sections)


def test_all_wrong_sensors_are_reported_at_once(tmp_path: Path) -> None:
    sections = TABLE.replace("beams: 90", "beams: -1").replace("focal_px: 60", "focal_px: far")
    assert [finding.split(":")[0] for finding in findings(tmp_path, sections)] == ["10", "12"]


def test_copy_with_an_older_key_changes_the_first_of_its_kind(tmp_path: Path) -> None:
    robot = read(tmp_path, TABLE)
    shorter = robot.sensors["rear"].model_copy(update={"reach_m": 2.0})
    changed = robot.model_copy(update={"range_sensor": shorter, "camera": None})
    assert changed.sensors["front"] is shorter
    assert "mast" not in changed.sensors
    assert robot.range_sensor is not shorter


def test_robot_without_errors_has_no_noise_in_any_sensor(tmp_path: Path) -> None:
    ideal = read(tmp_path, TABLE + "errors: {none: true}\n")
    assert [spec.sigma_mm for spec in ideal.all_of(RangeSpec).values()] == [0.0, 0.0]
    assert ideal.imu is not None
    assert ideal.imu.accelerometer_sigma_m_s2 == 0.0
    assert ideal.link_of(ideal.imu) == "base"


def test_links_name_a_frame_by_the_programs_name(tmp_path: Path) -> None:
    """The key `links` renames a link; a sensor may still call it as the URDF does."""
    robot = read(tmp_path, f"range_sensor: {LIDAR}\nlinks: {{range_sensor: laser}}\n")
    assert robot.lidar_link == "range_sensor"
