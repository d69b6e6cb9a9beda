"""Radio beacons from a robot's file to where the robot is, and to a log of the drive."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.beacons import Beacons
from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.conformance.checks.beacon_checks import beacons
from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.offline_localization.drive_recorder import DriveRecorder
from handcart.evaluation.offline_localization.logs.csv_log import read_csv_log
from handcart.evaluation.offline_localization.replay import NoRanges, localizer_for, replay
from handcart.evaluation.offline_localization.replay_words import in_words
from handcart.evaluation.trials.rig import RigFiles
from handcart.files.errors import FileError
from handcart.networks.task.preparing import prepare
from handcart.robotics.navigation.beacons.beacon_filter import BeaconFilter
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE

TASK = Path(__file__).parents[4] / "tasks" / "deploy_straight" / "task.yaml"
BEACONS = """\
beacons:
  places_m: {north: [10, 12, 2.0], south: [12, -14, 2.0], behind: [-9, 1, 1.5], far: [300, 0, 2]}
  tag_m: [-0.1, 0.1, 1.0]
  sigma_m: 0.05
  bias_m: 0.3
"""
WORLD = "format: handcart-world/1\nstart: {x_m: 0.0, y_m: 0.0}\nground: {}\nsensors: {count: 17}\n"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """El Verde, with beacons instead of satellites."""
    shipped = robot_path("el_verde")
    shutil.copy(shipped.parent / "el_verde.urdf", tmp_path)
    text = shipped.read_text(encoding="utf-8").replace("localizer: gps_filter", "localizer: beacons")
    gps = text[text.index("gps:  ") : text.index("ground: {}")]
    path = tmp_path / "robot.yaml"
    path.write_text(text.replace(gps, BEACONS), encoding="utf-8")
    return path


@pytest.fixture
def world(tmp_path: Path) -> Callable[[str], Path]:
    def made(more: str) -> Path:
        path = tmp_path / "world.yaml"
        path.write_text(WORLD + more, encoding="utf-8")
        return path

    return made


def test_the_check_finds_them_right(robot: Path, world: Callable[[str], Path]) -> None:
    files = RigFiles(world(""), None, None, {}, "")
    found = CheckResult("beacons", "")
    beacons(KitBench("kinematic", str(robot), files=files), found)
    assert found.wrong == []


@pytest.mark.slow
def test_a_robot_knows_where_it_is_by_them_and_its_log_tells_it_again(
    robot: Path, world: Callable[[str], Path], tmp_path: Path
) -> None:
    settings = {"robot": str(robot), "world": str(world(""))}
    recorder = DriveRecorder()
    with prepare(TASK, None, settings, 4) as prepared:
        moving = prepared.robot
        assert not moving.localization.dead_reckoned
        recorder.begin(prepared, tmp_path)
        for number in range(1600):
            moving.base.drive(0.4 if number > 400 else 0.0, 0.02 if number > 400 else 0.0)
            moving.step()
            recorder.period(moving)
        recorder.end()
        truth, pose = prepared.backend.ground_truth(), moving.pose
        assert truth is not None
        assert pose.distance(truth.base) < 0.2
        assert 3.0 * moving.localization.sigma[0] < 0.5
        assert moving.localization.doubt is None
    log = read_csv_log(tmp_path / "drive.csv")
    assert log.beacons is not None
    assert np.isnan(log.beacons.ranges[:, 3]).all()  # out of reach
    played = replay(log, localizer_for(log, REFERENCE_NOISE, "beacons"))
    assert np.hypot(*(played.poses[-1, :2] - np.array(pose)[:2])) < 0.05
    assert np.hypot(*played.errors[-1, :2]) < 0.2
    assert re.match(r"40 s, 600 ranges, 0 of them refused\n", in_words(played))
    with pytest.raises(NoRanges, match="the log has no ranges"):
        localizer_for(log._replace(beacons=None), REFERENCE_NOISE, "beacons")
    with pytest.raises(NoRanges, match="heading_deg"):
        localizer_for(log._replace(start=(0.0, 0.0, math.nan)), REFERENCE_NOISE, "beacons")


def test_rows_of_one_time_are_put_together_beacon_by_beacon(
    tmp_path: Path,
) -> None:
    path = tmp_path / "log.csv"
    header = "---\nformat: handcart-log/1\nbeacons: {places_m: {a: [0, 0, 1], b: [9, 0, 1]}}\ncolumns:\n"
    columns = "  time: {unit: s}\n  speed: {unit: m/s}\n  gyro_z: {unit: rad/s}\n"
    ranges = "  range_a: {unit: m}\n  range_b: {unit: mm}\n---\n"
    rows = "time,speed,gyro_z,range_a,range_b\n0,0,0,1,\n1,0,0,2,\n1,0,0,,3000\n2,0,0,,\n"
    path.write_text(header + columns + ranges + rows, encoding="utf-8")
    log = read_csv_log(path).one_row_a_time()
    assert log.beacons is not None
    assert log.beacons.ranges[1].tolist() == [2.0, 3.0]
    path.write_text(header + columns + ranges.replace("range_b", "range_c") + rows, encoding="utf-8")
    with pytest.raises(FileError, match=r"no such quantity: 'range_c'.*range_b"):
        read_csv_log(path)


def test_the_world_says_which_beacon_was_moved_and_how_biases_wander(
    robot: Path, world: Callable[[str], Path]
) -> None:
    """From a moment on; the robot's file says where it should be."""
    more = "beacons: {places_m: {north: [10, 22, 2.0]}, moved_at_s: 2.0, bias_walk_m_rt_s: 1.0e-9}\n"
    settings = {"robot": str(robot), "world": str(world(more))}
    with prepare(TASK, None, settings, 4) as prepared:
        radio = prepared.robot.get(Beacons)  # type: ignore[type-abstract]
        heard: list[Any] = []
        for _ in range(160):
            prepared.robot.step()
            reading = radio.ranges()
            if reading is not None:
                heard.append(reading.distances)
        moved = np.mean(heard[12:], axis=0)[:3] - np.mean(heard[:9], axis=0)[:3]
        assert moved[0] > 5.0
        assert np.abs(moved[1:]).max() < 0.2


def test_what_is_wrong_in_a_robot_s_file_is_told(robot: Path) -> None:
    text = robot.read_text(encoding="utf-8")
    robot.write_text(text.replace(BEACONS, ""), encoding="utf-8")
    with pytest.raises(FileError, match=r"robot\.yaml:\d+:\d+: the robot hears no beacons"):
        load_robot(str(robot))


def test_without_errors_they_are_exact(robot: Path) -> None:
    spec = load_robot(str(robot)).without_errors().beacons
    assert spec is not None
    assert (spec.sigma_m, spec.bias_m) == (0.0, 0.0)
    assert isinstance(spec.places_m["north"], tuple)
    assert BeaconFilter.TAKES_RANGES
