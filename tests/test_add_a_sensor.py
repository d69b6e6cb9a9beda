"""A kind of sensor of another package: the one that docs/how_to/add_a_sensor.md shows, installed."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from benchmarks.contract.sensor_kinds import named_outside

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "how_to" / "add_a_sensor.md").read_text(encoding="utf-8")
FRAMES = """
  <link name="bumper"/>
  <joint name="b1" type="fixed"><parent link="base"/><child link="bumper"/><origin xyz="0.3 0 0.2"/></joint>
  <link name="bumper_rear"/>
  <joint name="b2" type="fixed"><parent link="base"/><child link="bumper_rear"/>
    <origin xyz="-0.3 0 0.2" rpy="0 0 3.14159265"/></joint>
</robot>
"""
READS = """
import json, sys
from pathlib import Path
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2
from sonar import Sonar
read = {}
for name in sys.argv[1:]:
    spec = load_robot("robot.yaml")
    with make_backend(name, spec, Path("world.yaml"), 1) as backend:
        robot = Robot(backend, spec, Pose2(1.0, 1.5, 0.0))
        robot.step()
        front, rear = robot.sensor("front"), robot.sensor("rear")
        first, state = front.distance(), backend.state()
        assert front.distance() == first and robot.get(Sonar) is front
        read[name] = [first, rear.distance(), "sensor rear" in state]
print(json.dumps(read))
"""
CHECKS = """
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.faults.fault import all_sensors
from handcart.evaluation.conformance.rig.bench import KitBench
bench = KitBench("kinematic", "robot.yaml")
for name in ("sonar", "capabilities"):
    found = checks()[name](bench)
    print(found.wrong, found.skipped)
print("sonar" in all_sensors())
"""
WORLD = """\
format: handcart-world/1
start: {x_m: 1.0, y_m: 1.5, heading_deg: 0}
walls:
  - {from_m: [0, 0], to_m: [3, 0]}
  - {from_m: [3, 0], to_m: [3, 3]}
  - {from_m: [3, 3], to_m: [0, 3]}
  - {from_m: [0, 3], to_m: [0, 0]}
"""


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.S)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A folder with the package as pip would leave it, a robot that has the sensors, and a world."""
    code, checks = blocks("python")
    (tmp_path / "sonar.py").write_text(code, encoding="utf-8")
    (tmp_path / "sonar_checks.py").write_text(checks, encoding="utf-8")
    info = tmp_path / "sonar-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: sonar\nVersion: 1.0\n", encoding="utf-8")
    points = re.sub(r'\[project\.entry-points\."(.*)"\]', r"[\1]", blocks("toml")[0]).replace('"', "")
    (info / "entry_points.txt").write_text(points, encoding="utf-8")
    cart = ROOT / "backends" / "robots" / "cart"
    urdf = (cart / "cart.urdf").read_text(encoding="utf-8").replace("</robot>", FRAMES)
    (tmp_path / "cart.urdf").write_text(urdf, encoding="utf-8")
    text = (cart / "robot.yaml").read_text(encoding="utf-8")
    text = text.replace("  start_mm: 20.0\n  start_deg: 1.0\n", "  start_mm: 0\n  start_deg: 0\n")
    (tmp_path / "robot.yaml").write_text(text + blocks("yaml")[0], encoding="utf-8")
    (tmp_path / "world.yaml").write_text(WORLD, encoding="utf-8")
    return tmp_path


def python(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    env = os.environ | {"PYTHONPATH": str(folder)}
    command = [sys.executable, *words]
    return subprocess.run(command, env=env, cwd=folder, capture_output=True, text=True, check=False)


def handcart(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return python(folder, "-m", "handcart", *words)


@pytest.mark.slow
def test_sonar_of_the_page_reads_on_every_simulated_backend(package: Path) -> None:
    names = ["kinematic", "mujoco", *(["pybullet"] if find_spec("pybullet") else [])]
    said = python(package, "-c", READS, *names)
    assert said.returncode == 0, said.stderr
    read = json.loads(said.stdout.splitlines()[-1])
    assert list(read) == names
    for front, rear, saved in read.values():
        assert front == pytest.approx(2.95 - 1.3, abs=0.05)
        assert rear == pytest.approx(0.7 - 0.05, abs=0.05)
        assert saved


@pytest.mark.slow
def test_sonar_of_the_page_is_checked_and_reported(package: Path) -> None:
    assert "cone_deg" in handcart(package, "schema", "robot").stdout
    said = python(package, "-c", CHECKS)
    assert said.stdout.splitlines()[-3:] == ["[] ", "[] ", "True"], said.stderr
    robot = package / "robot.yaml"
    robot.write_text(
        robot.read_text(encoding="utf-8").replace("reach_m: 1.5", "reech_m: 1.5"), encoding="utf-8"
    )
    said = handcart(package, "check", "robot.yaml")
    assert said.returncode == 2
    assert re.search(r"robot\.yaml:\d+:\d+: unknown key 'reech_m'; did you mean 'reach_m'\?", said.stderr)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "wrong"),
    [
        ("raise RuntimeError('broken')", "RuntimeError: broken"),
        (
            "from handcart.backends.sensors.sensor_kind import SensorKind as K\nSONAR = K('s', 'a:b', 'a:b')",
            "sonar:SONAR is of the kind 's'",
        ),
    ],
)
def test_broken_kind_is_reported_with_its_package(package: Path, code: str, wrong: str) -> None:
    (package / "sonar.py").write_text(code, encoding="utf-8")
    said = handcart(package, "check", "robot.yaml")
    assert said.returncode == 2
    assert "the kind of sensor 'sonar' of the package sonar" in said.stderr
    assert f"can't be used: {wrong}" in said.stderr
    assert "Traceback" not in said.stderr


@pytest.mark.slow
def test_robot_without_the_sensor_runs_beside_a_broken_kind(package: Path) -> None:
    (package / "sonar.py").write_text("raise RuntimeError('broken')", encoding="utf-8")
    untouched = handcart(package, "run", str(ROOT / "tasks" / "drive_map" / "task.yaml"), "--dry-run")
    assert untouched.returncode == 0, untouched.stderr


@pytest.mark.slow
def test_new_kind_edits_one_file_beside_its_own() -> None:
    """A depth camera is the latest kind; its name is in the registry alone."""
    assert named_outside("depth_camera") == ["backends/sensors/sensor_kind.py"]
