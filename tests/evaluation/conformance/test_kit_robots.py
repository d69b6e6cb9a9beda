"""The checks of the conformance kit, with robots that are slow, or have several sensors of a kind."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.backends.capabilities.range_sensor import Scan
from handcart.backends.description.robot_names import robot_path
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.rig.bench import KitBench

SENSORS = """
sensors:
  second: {kind: lidar, frame: range_sensor, beams: 360, reach_m: 12.0, sigma_mm: 10}
  uwb: {kind: beacons, places_m: {a: [0, 0, 2], b: [5, 0, 2], c: [0, 5, 2]}}
  room: {kind: positioning, sigma_mm: 5, heading_sigma_mrad: 2, rate_hz: 10}
  cell: {kind: battery, capacity_wh: 100}
  gyro: {kind: imu, frame: base, angle_random_walk_deg_rt_s: 0.1, accelerometer_sigma_m_s2: 0.01}
"""


@pytest.fixture
def slow(tmp_path: Path) -> KitBench:
    """A cart of 0.08 m/s and 12 deg/s, with radio beacons, a second lidar and other sensors."""
    folder = Path(shutil.copytree(robot_path("cart").parent, tmp_path / "cart"))
    lines = (folder / "robot.yaml").read_text(encoding="utf-8").splitlines()
    slower = {"  top_speed_m_s": "0.08", "  top_turn_deg_s": "12"}
    text = "\n".join(
        f"{key}: {slower[key]}" if (key := line.partition(":")[0]) in slower else line for line in lines
    )
    (folder / "robot.yaml").write_text(text + SENSORS, encoding="utf-8")
    return KitBench("kinematic", str(folder / "robot.yaml"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        *("base", "scan's frame", "rates", "period", "seed", "snapshot", "tolerances", "navigation"),
        *("positioning", "imu", "beacons", "battery", "drift"),
    ],
)
def test_a_slow_robot_passes(slow: KitBench, name: str) -> None:
    """Each check drove with 0.2 m/s or 0.5 rad/s, whatever the robot's file said, and broke."""
    finding = checks()[name](slow)
    assert finding.wrong == []
    assert not finding.skipped


def test_a_sensor_that_measures_seldom_is_no_missing_reading(slow: KitBench) -> None:
    """The beacons are heard in every fourth period."""
    finding = checks()["rates"](slow)
    assert finding.wrong == []
    assert any("beacons ranges" in words for words in finding.measured)


def test_each_of_two_lidars_is_checked(slow: KitBench, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last one of a kind hid those before it."""
    scan, count = SimulatedRangeSensor.scan, [0]

    def another(sensor: SimulatedRangeSensor) -> Scan:
        count[0] += 1
        read = scan(sensor)
        first = sensor.sensor_name == "range_sensor"
        return read._replace(ranges=read.ranges + 1e-3 * count[0]) if first else read

    monkeypatch.setattr(SimulatedRangeSensor, "scan", another)
    assert checks()["rates"](slow).wrong == ["asked again, range sensor scan of range_sensor is another"]
