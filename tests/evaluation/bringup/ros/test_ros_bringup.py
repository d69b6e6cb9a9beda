"""Bring-up by ROS 2 finds a robot that is not as its file says."""

from __future__ import annotations

import math
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.capabilities.scan import Scan
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.bench.robot_differences import RobotDifferences
from handcart.evaluation.bringup.ladder import BenchFirst, Ladder
from handcart.evaluation.bringup.operator import BenchOperator, ScriptedOperator
from handcart.evaluation.bringup.ros.base_rung import BaseRung
from handcart.evaluation.bringup.ros.gripper_rung import GripperRung
from handcart.evaluation.bringup.ros.joints_rung import JointLag, JointsRung, nudge
from handcart.evaluation.bringup.ros.procedure import ROS_RUNGS
from handcart.evaluation.bringup.ros.ros_site import RosSite
from handcart.evaluation.bringup.ros.scan_turn import check_side
from handcart.evaluation.bringup.ros.silence_rung import SilenceRung
from handcart.evaluation.bringup.ros.unit_words import unit_hint
from handcart.evaluation.bringup.rung import RungFailed
from handcart.evaluation.bringup.use_rungs import RangesRung
from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.files.errors import InputError
from handcart.files.models.loading import load
from handcart.networks.runs.calibration import CALIBRATION_FILE, Calibration
from handcart.robotics.geometry.pose2 import Pose2


@pytest.fixture(scope="module")
def librarian() -> RobotFile:
    """A robot with an arm; its camera, whose pictures take time, is left at home."""
    robot = load_robot("librarian")
    assert robot.camera is not None
    return robot.with_sensors({robot.name_of(robot.camera): None}).read_in(robot.folder)


@pytest.fixture
def site_of(tmp_path: Path, librarian: RobotFile) -> Any:
    """Return a function that makes a site: the robot, and how it differs from its file."""

    def made(name: str, *wrong: str) -> RosSite:
        robot = librarian if name == "librarian" else load_robot(name)
        task = LIBRARY_FOLDER.parent / "drive_map" / "task.yaml"
        world = LIBRARY_FOLDER / "world.yaml"
        site = RosSite(name, robot, BenchOperator(), tmp_path / "records", task, "kinematic", world)
        site.differences = RobotDifferences.read(wrong, robot, site.spec)
        return site

    return made


def test_the_time_without_commands_is_measured(site_of: Any) -> None:
    facts = SilenceRung().climb(site_of("cart"))
    assert 0.2 <= facts["kept_s"] <= 0.35
    assert facts["kept_s"] <= facts["rest_s"] <= 0.5


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("timeout=0.7", "keeps its last speeds for 0.[67]"),
        ("timeout=60", "keeps its last speeds longer than 3"),
        ("velocity.forward=0.01745", "the odometry shows"),
    ],
)
def test_a_base_that_keeps_its_speeds_is_refused(site_of: Any, wrong: str, words: str) -> None:
    with pytest.raises(RungFailed, match=words):
        SilenceRung().climb(site_of("cart", wrong))


def test_a_base_as_its_file_says_passes(site_of: Any) -> None:
    facts = BaseRung().climb(site_of("cart"))
    assert facts["forward_mm"] == pytest.approx(300, abs=15)
    assert facts["forward_by_odometry_mm"] == pytest.approx(300, abs=15)
    assert facts["turn_deg"] == pytest.approx(40, abs=3)
    assert 0.0 < facts["forward_latency_s"] <= 0.15
    assert facts["lidar_turn_checked"] is True


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("odometry.forward=-1", r"odom \(forward\): .* the sign is the other way round"),
        ("scan.side=-1", r"scan: the base turned by .* turned with it .* `upside_down: true` in"),
        ("odometry.turn=-1", r"odom \(turn\): .* the sign is the other way round"),
        ("odometry.forward=1.3", "a factor of 1.3"),
        ("velocity.forward=-1", r"cmd_vel \(forward\): .* the sign is the other way round"),
        ("velocity.turn=-1", r"cmd_vel \(turn\): .* the sign is the other way round"),
        ("velocity.turn=0.01745", "degrees"),
    ],
)
def test_a_wrong_axis_of_the_base_is_found(site_of: Any, wrong: str, words: str) -> None:
    with pytest.raises(RungFailed, match=words):
        BaseRung().climb(site_of("cart", wrong))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("joint_6=-1", "joint_6: .* the sign is the other way round: add it to `reversed`"),
        ("joint_6=57.2958", "joint_6: .* degrees"),
        ("joint_1=-1", "by the readings the hand is at .* is a joint's sign, zero or unit another one"),
        ("joint_4=0.5", "joint_4: .* a factor of 0.5"),
        ("state.joint_1=-1", "by the readings the hand is at"),
        ("joints.latency=0.4", r"joint_1: its reading follows 0.4\d s after the command; allowed: 0\.\d+ s"),
    ],
)
def test_a_wrong_joint_is_found(site_of: Any, wrong: str, words: str) -> None:
    with pytest.raises(RungFailed, match=words):
        JointsRung().climb(site_of("librarian", wrong))


def test_the_latency_of_a_joint_is_measured(site_of: Any) -> None:
    latencies = []
    for wrong in ((), ("joints.latency=0.1",)):
        site = site_of("librarian", *wrong)
        with site.backend() as backend, site.operator.hold("") as held:
            latencies.append(nudge(site, backend, 0, 0.1, held).latency_s)
    assert latencies[1] - latencies[0] == pytest.approx(0.1, abs=1e-9)


def test_reading_that_moves_before_its_command_has_no_lag() -> None:
    """Readings follow two periods late, with noise, and in the second case an earlier command moves them."""
    command = np.minimum(0.02 * np.arange(1, 12), 0.1)
    late = np.concatenate([[0.0, 0.0], command[:-2]])
    for earlier, periods in ((0.0, 2.0), (0.05, math.nan)):
        lag = JointLag(0.05)
        for commanded, read in zip(command, np.maximum(late + 0.004, earlier), strict=True):
            lag.note(commanded, read)
        assert lag.periods == pytest.approx(periods, nan_ok=True)


def test_joint_that_follows_an_earlier_command_has_no_latency(site_of: Any) -> None:
    site = site_of("librarian", "joints.latency=0.1")
    with site.backend() as backend, site.operator.hold("") as held:
        arm = backend.get(Arm)
        arm.move(arm.command() + 0.07 * np.eye(len(arm.command()))[0])
        backend.step()
        assert math.isnan(nudge(site, backend, 0, 0.1, held).latency_s)


def test_latency_of_a_joint_that_was_moved_is_refused(site_of: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(JointLag, "periods", math.nan)
    with pytest.raises(RungFailed, match="joint_1: its reading moved before its command"):
        JointsRung().climb(site_of("librarian"))


@pytest.mark.parametrize("wrong", ["gripper=1000", "gripper=0.5"])
def test_a_wrong_gripper_is_found(site_of: Any, wrong: str) -> None:
    with pytest.raises(RungFailed, match="`open` and `closed`"):
        GripperRung().climb(site_of("librarian", wrong))


def test_fingers_that_would_count_as_pressing_too_soon_are_found(site_of: Any) -> None:
    words = r"its reading follows 0\.\d+ s after the command; allowed: 0\.15 s \(`rest_ms`\)"
    with pytest.raises(RungFailed, match=words):
        GripperRung().climb(site_of("librarian", "gripper.latency=0.2"))


@pytest.mark.slow
def test_arm_and_gripper_as_their_file_says_pass(site_of: Any) -> None:
    site = site_of("librarian")
    facts = JointsRung().climb(site)
    assert set(facts) == {"hand_off_mm", *site.robot.arm.joints}
    assert all(facts[name]["latency_s"] <= 0.1 for name in site.robot.arm.joints)
    facts = GripperRung().climb(site)
    assert facts["width_at_60_percent_mm"] == pytest.approx(42, abs=2)
    assert 0.0 < facts["latency_s"] <= 0.1


def scans(shape: str, side: int, beams: int = 360) -> tuple[Scan, Scan]:
    """Return scans before and after a turn of 40 deg to the left; a mirrored lidar has the side -1."""
    angles = np.linspace(-math.pi, math.pi, beams, endpoint=False)
    rng = np.random.default_rng(3)

    def taken(heading: float) -> Scan:
        way = side * angles + heading
        wide = np.maximum(np.abs(np.cos(way)), np.abs(np.sin(way)))
        off = 0.3 if shape == "beside the middle" else 0.0
        room = {"square": 2.0 / wide, "empty": np.full(beams, np.inf)}
        ranges = room.get(shape, 3.0 - off * np.cos(way)) + rng.normal(0.0, 0.01, beams)
        return Scan(angles, ranges, Pose2(0.0, 0.0, 0.0))

    return taken(0.0), taken(math.radians(40.0))


@pytest.mark.parametrize("shape", ["square", "beside the middle"])
def test_a_mirrored_lidar_is_found_in_a_symmetric_room(site_of: Any, shape: str) -> None:
    site, turn = site_of("cart"), math.radians(40.0)
    check_side(site, *scans(shape, 1), turn)
    with pytest.raises(RungFailed, match="turned with it instead of against it"):
        check_side(site, *scans(shape, -1), turn)


@pytest.mark.parametrize(
    ("shape", "words"), [("round", "fits both ways"), ("empty", "fewer than 20 beams return")]
)
@pytest.mark.parametrize("side", [1, -1])
def test_a_round_room_does_not_determine_the_side(site_of: Any, shape: str, words: str, side: int) -> None:
    with pytest.raises(RungFailed, match=f"can't be determined which way round .*{words}"):
        check_side(site_of("cart"), *scans(shape, side), math.radians(40.0))


def test_a_person_who_sees_another_motion_is_believed(site_of: Any) -> None:
    site = site_of("cart")
    site.operator = ScriptedOperator({"clear": True, "forward_mm": -298.0})
    with pytest.raises(RungFailed, match="the base moved -298 mm; the sign is the other way round"):
        BaseRung().climb(site)


def test_a_failed_step_is_recorded_and_tried_again(site_of: Any) -> None:
    site = site_of("cart", "timeout=60")
    ladder = Ladder(site, rungs=ROS_RUNGS)
    assert ladder.climb().passed
    failed = ladder.climb()
    assert not failed.passed
    assert failed.rung == "silence"
    assert (site.folder / "02_silence.yaml").is_file()
    site.differences = RobotDifferences()
    again = Ladder(site, rungs=ROS_RUNGS)
    assert again.next is not None
    assert again.next.name == "silence"
    assert again.climb().passed


def test_a_robot_by_topics_is_tried_on_the_bench_first(site_of: Any, tmp_path: Path) -> None:
    ladder = Ladder(site_of("cart"), rehearsed=tmp_path / "none", rungs=ROS_RUNGS)
    with pytest.raises(BenchFirst, match="handcart bringup cart --ros2 --bench kinematic --all"):
        ladder.climb()


def test_wrong_differences_are_told_at_once(librarian: RobotFile) -> None:
    assert librarian.ros2 is not None
    words = ("joint_9=-1", "odometry.turn=zero", "gripper=0", "joint_1=-1")
    with pytest.raises(InputError) as refused:
        RobotDifferences.read(words, librarian, librarian.ros2)
    assert len(str(refused.value).splitlines()) == 3
    assert "'joint_9' is no difference of this robot" in str(refused.value)


@pytest.mark.parametrize(
    ("read", "true", "words"),
    [
        (57.0, 1.0, "degrees"),
        (-1.0, 1.0, "the sign is the other way round"),
        (-1000.0, 1.0, "the sign is the other way round, and a factor of 1e+03: millimetres?"),
        (0.0, 1.0, "one of both stood still"),
        (1.4, 1.0, "a factor of 1.4"),
    ],
)
def test_a_ratio_suggests_its_cause(read: float, true: float, words: str) -> None:
    assert words in unit_hint(read, true)


class SlowLidar(RangeSensor):
    """Lidar that delivers a new scan every `every` readings, and the same object in between."""

    def __init__(self, every: int) -> None:
        self._every, self._readings, self._draws = every, 0, np.random.default_rng(0)
        self._scan: Scan | None = None

    @override
    def scan(self) -> Scan:
        if self._scan is None or self._readings % self._every == 0:
            ranges = 1.0 + 0.01 * self._draws.standard_normal(360)
            self._scan = Scan(np.linspace(-3.1, 3.1, 360), ranges, Pose2(0.0, 0.0, 0.0))
        self._readings += 1
        return self._scan


def with_lidar(site: RosSite, lidar: SlowLidar, monkeypatch: pytest.MonkeyPatch) -> RosSite:
    steps = SimpleNamespace(period=0.05, get=lambda kind: lidar, step=lambda: None)
    monkeypatch.setattr(site, "backend", lambda: nullcontext(steps))
    monkeypatch.setattr(site.operator, "number", lambda *_: 1.0)
    site.folder.mkdir()
    return site


def test_the_spread_of_ranges_counts_each_scan_once(site_of: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    site = with_lidar(site_of("cart"), SlowLidar(12), monkeypatch)
    facts = RangesRung().climb(site)
    # 30 s at 20 periods a second have 600 readings or more: at most two a period.
    assert 50 <= facts["scans"] <= 101
    found = load(site.folder / CALIBRATION_FILE, Calibration).found["range_sensor.sigma_mm"]
    assert found.value == pytest.approx(10.0, rel=0.05)
    assert found.sigma == pytest.approx(10.0 / math.sqrt(2 * facts["scans"]), rel=0.1)


def test_a_lidar_that_repeats_its_scans_is_not_calibrated(
    site_of: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    site = with_lidar(site_of("cart"), SlowLidar(10_000), monkeypatch)
    with pytest.raises(RungFailed, match="0 new scans came within 30 s; needed: 20"):
        RangesRung().climb(site)
