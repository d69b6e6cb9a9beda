"""Recorded bags in place of a robot's drivers: readings arrive as they did over the air."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rosbags", reason="bags are read by the extra `bags`")

from benchmarks.ros2.bags import SPOILED_S, played, player, playing_error, record, spoil_of
from handcart.backends.backend import RobotFault
from handcart.backends.description.ros_spec import RosOdometrySpec, RosSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.bag_playing.bag_link import BagLink
from handcart.evaluation.bag_playing.recorded_report import recorded_report
from handcart.files.errors import FileError

PERIODS = 16


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag without faults."""
    path = tmp_path_factory.mktemp("bags") / "whole"
    record(path, "SQLITE3", PERIODS, None)
    return path


@pytest.mark.slow
def test_readings_of_a_bag_are_those_over_the_air(tmp_path: Path) -> None:
    live = record(tmp_path / "bag", "MCAP", PERIODS, None)
    assert list(played(tmp_path / "bag", PERIODS)) == live
    assert live[-1].left > 0.02
    assert live[-1].joints[0] - live[0].joints[0] == pytest.approx(0.075, abs=0.01)


def test_the_end_of_a_bag_is_silence(whole: Path) -> None:
    with player(whole) as backend, pytest.raises(RobotFault, match=r"\(odom\)"):
        for _ in range(2 * PERIODS):
            backend.step()


@pytest.mark.parametrize(
    ("kind", "topic", "words"),
    [
        ("another frame", "odom", r"the odometry (odom): .*its frame is 'nowhere'"),
    ],
)
def test_a_spoiled_topic_of_a_bag_is_named(tmp_path: Path, kind: str, topic: str, words: str) -> None:
    record(tmp_path / "bag", "SQLITE3", PERIODS, spoil_of(kind, topic))
    said = playing_error(tmp_path / "bag", PERIODS)
    first, _, rest = words.partition(".*")
    assert first.strip() in said
    assert rest in said
    assert SPOILED_S < 1.0 + PERIODS * 0.05


def test_a_report_compares_a_file_with_a_bag(whole: Path) -> None:
    robot = load_robot("librarian")
    report = recorded_report(robot, RosSpec(first_message_s=0.2), whole, 5.0)
    assert not report.faults
    rates = {topic.topic: topic.rate_hz for topic in report.topics}
    assert rates["scan"] == pytest.approx(20.0, abs=0.5)
    assert report.nodes["odom"] == ["/bag (nav_msgs/Odometry)"]
    spec = RosSpec(first_message_s=0.2, odometry=RosOdometrySpec(topic="wheels/odom"))
    other = [fault.words for fault in recorded_report(robot, spec, whole, 5.0).faults]
    assert other == ["the odometry (wheels/odom): nobody publishes it; there are /odom"]


def test_a_file_that_is_no_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"no bag")
    with pytest.raises(FileError, match="no bag that can be read"):
        BagLink(tmp_path / "a.mcap")


def test_a_missing_bag_is_called_missing(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"b\.mcap: no such file or folder; allowed: rosbag2"):
        BagLink(tmp_path / "b.mcap")
