"""A robot's file held against the topics of a bench whose robot is another one."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any

import pytest

from handcart.backends.backend import Backend
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.air_check.air_report import AirReport, listen
from handcart.backends.ros2.bench.bench_faults import BenchFaults, TopicFault
from handcart.backends.ros2.bench.local_air import LocalLink
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.wire.messages import set_stamp
from handcart.files.errors import InputError
from tests.backends.ros2.conftest import WORLD

ARM = tuple(f"joint_{number}" for number in range(1, 7))

SECONDS = 0.8


@pytest.fixture(scope="module")
def seeing() -> RobotFile:
    """A robot with a camera, whose pictures take their time."""
    return load_robot("librarian")


@pytest.fixture(scope="module")
def robot(seeing: RobotFile) -> RobotFile:
    assert seeing.camera is not None
    return seeing.with_sensors({seeing.name_of(seeing.camera): None}).read_in(seeing.folder)


@pytest.fixture(scope="module")
def inner(robot: RobotFile) -> Iterator[Backend]:
    """Share one simulated robot: it is never moved."""
    with KinematicBackend.build(robot, WORLD, 0) as backend:
        yield backend


@pytest.fixture
def hear(robot: RobotFile, inner: Backend) -> Any:
    """Return a function that listens to a bench: what the file says, the bench's own section, faults."""

    def heard(
        said: dict[str, Any] | None = None,
        true: dict[str, Any] | None = None,
        faults: tuple[str, ...] = (),
        others: tuple[tuple[str, str], ...] = (),
        seconds: float = SECONDS,
    ) -> AirReport:
        planned = BenchFaults(robot.period_s, tuple(map(TopicFault.read, faults)))
        bench = LocalBench(robot, RosSpec(**(true or {})), inner, planned)
        other = LocalLink(bench.air, "teleop")
        for kind, topic in others:
            other.publisher(kind, topic)
        spec = RosSpec(**{"first_message_s": 0.5, **(said or {})})
        return listen(robot, spec, bench.link, bench.step, seconds)

    return heard


def test_a_bench_that_fits_has_no_findings(hear: Any) -> None:
    report = hear()
    assert report.faults == ()
    assert report.remarks == ()
    measured = {topic.topic: topic for topic in report.topics}
    assert measured["odom"].rate_hz == pytest.approx(20.0, rel=0.01)
    assert measured["odom"].frames == ("odom",)
    assert report.nodes["cmd_vel"] == ["/bench (geometry_msgs/Twist)"]


@pytest.mark.parametrize(
    ("said", "true", "key", "words"),
    [
        (
            {"velocity": {"type": "TwistStamped"}},
            {},
            "velocity",
            "cmd_vel: /bench (geometry_msgs/Twist) listens, but geometry_msgs/TwistStamped is sent",
        ),
        ({}, {"odometry": {"topic": "wheel/odom"}}, "odometry", "nobody publishes it; there are wheel/odom"),
        ({"odometry": {"topic": "odom", "frame": "map"}}, {}, "odometry", "frame is 'odom'; allowed: 'map'"),
        ({}, {"names": {"joint_2": "joint_2_motor"}}, "joint_states", "no message has the joint 'joint_2'"),
        ({}, {"reversed": ("joint_2",)}, "reversed", "beyond its limit"),
        (
            {},
            {"velocity": {"topic": "base/cmd_vel"}},
            "velocity",
            "cmd_vel: nobody listens to it; needed: a controller or driver that takes geometry_msgs/Twist;"
            " there are base/cmd_vel",
        ),
        (
            {"arm": {"actions": {"arm/goals": ARM}}},
            {"arm": {"actions": {"left_arm/goals": ARM}}},
            "arm",
            "arm/goals: nobody serves the action; needed: a controller that takes"
            " control_msgs/FollowJointTrajectory; there are left_arm/goals",
        ),
        ({}, {"arm": {"controllers": {"lift": ()}}}, "arm", "arm_controller/joint_trajectory: nobody"),
    ],
)
def test_a_difference_is_found_at_its_key(
    hear: Any, said: dict[str, Any], true: dict[str, Any], key: str, words: str
) -> None:
    faults = hear(said, true).faults
    assert any(fault.key[1] == key and words in fault.words for fault in faults), faults


def test_a_lidar_upside_down_is_found_until_the_file_says_so(hear: Any) -> None:
    flipped = {"lidar": {"upside_down": True}}
    faults = [fault.words for fault in hear({}, flipped, seconds=0.2).faults]
    assert any("180.0 deg from where" in words and "`upside_down`" in words for words in faults), faults
    assert hear(flipped, flipped, seconds=0.2).faults == ()


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("nan@scna", "'scna' is not a topic of this bench; did you mean 'scan'?"),
        ("rejects@odom", "'odom' is not an action of this bench; allowed: nothing"),
    ],
)
def test_a_fault_that_the_bench_cannot_inject_is_refused(hear: Any, fault: str, words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        hear(faults=(fault,))


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("silent@scan@0.3", "the lidar (scan): no message for"),
        ("old-stamps@odom@0", "its stamp is 60 s old"),
        ("doubled@joint_states@0", "messages are refused: its stamp is 0 s before"),
        ("nan@odom@0.5", "its pose is not finite"),
        ("wrong-frame@scan@0.7", "its messages are in the frames 'range_sensor', 'nowhere'"),
    ],
)
def test_a_fault_on_the_wire_is_found(hear: Any, fault: str, words: str) -> None:
    faults = hear(faults=(fault,)).faults
    assert any(words in item.words for item in faults), faults


@pytest.mark.parametrize(
    ("kind", "topic", "words"),
    [
        ("geometry_msgs/Twist", "cmd_vel", "cmd_vel: /teleop (geometry_msgs/Twist) publishes it"),
        ("nav_msgs/Odometry", "odom", "2 nodes publish it"),
        ("sensor_msgs/PointCloud2", "scan", "nodes publish different types"),
    ],
)
def test_a_second_publisher_is_named(hear: Any, kind: str, topic: str, words: str) -> None:
    faults = hear(others=((kind, topic),)).faults
    assert len(faults) == 1
    assert words in faults[0].words


def test_several_differences_are_found_at_once(hear: Any) -> None:
    faults = hear(
        {"velocity": {"type": "TwistStamped"}, "lidar": {"topic": "scann"}, "names": {"joint_1": "j1"}}
    ).faults
    assert {fault.key[1] for fault in faults} == {"velocity", "lidar", "joint_states"}


def test_a_scan_without_returns_is_remarked(robot: RobotFile, inner: Backend) -> None:
    bench = LocalBench(robot, RosSpec(), inner)
    send = bench._drivers._send["scan"]

    def blind(message: Any) -> None:
        message.ranges = [math.inf] * len(message.ranges)
        send(message)

    bench._drivers._send["scan"] = blind  # type: ignore[index]
    report = listen(robot, RosSpec(), bench.link, bench.step, SECONDS)
    assert report.faults == ()
    assert [remark.words for remark in report.remarks if "no beam of its last scan returns" in remark.words]


def test_a_check_is_no_second_master(robot: RobotFile, inner: Backend) -> None:
    bench = LocalBench(robot, RosSpec(), inner)
    listen(robot, RosSpec(first_message_s=0.5), bench.link, bench.step, SECONDS)
    assert bench.link.publishers("cmd_vel") == []


@pytest.mark.parametrize("focal", [1.0, 1.05])
def test_a_camera_of_another_lens_is_found(seeing: RobotFile, focal: float) -> None:
    camera = seeing.camera
    assert camera is not None
    other = camera.model_copy(update={"focal_px": focal * camera.focal_px})
    said = seeing.with_sensors({seeing.name_of(camera): other}).read_in(seeing.folder)
    with KinematicBackend.build(seeing, WORLD, 0) as inner:
        bench = LocalBench(seeing, RosSpec(), inner)
        faults = listen(said, RosSpec(), bench.link, bench.step, 0.3).faults
    assert len(faults) == (focal != 1.0)
    if not faults:
        return
    assert "camera/camera_info: its lens" in faults[0].words


def test_a_second_node_that_sends_other_joints_is_found(robot: RobotFile, inner: Backend) -> None:
    bench = LocalBench(robot, RosSpec(), inner)
    other = LocalLink(bench.air, "joint_state_publisher")
    publish = other.publisher("sensor_msgs/JointState", "joint_states")
    assert robot.arm is not None
    names = list(robot.arm.joints)

    def wait() -> None:
        bench.step()
        message = other.message("sensor_msgs/JointState")
        set_stamp(message.header, other.now() + 1e-3)
        message.name, message.position = names, [0.0] * len(names)
        publish(message)

    faults = listen(robot, RosSpec(first_message_s=0.5), bench.link, wait, SECONDS).faults
    assert any("jumps by" in fault.words and "do two nodes send it?" in fault.words for fault in faults), (
        faults
    )
