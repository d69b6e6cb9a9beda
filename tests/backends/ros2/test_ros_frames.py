"""Frames by tf: sensors where the robot's file has them, and odometry where no topic has it."""

from __future__ import annotations

import math

import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.air_check.air_report import AirReport, listen
from handcart.backends.ros2.bench.bench_frames import BenchFrames
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.bench.local_messages import new_message
from handcart.backends.ros2.wire.frame_tree import FrameTree
from handcart.robotics.geometry.transform import Transform, transform

from .conftest import WORLD, Make

BY_FRAMES = {"odometry": {"topic": "tf", "type": "TFMessage", "frame": "odom"}}


def report_of(monkeypatch: pytest.MonkeyPatch, moved: dict[str, tuple[float, ...]]) -> AirReport:
    """Check the librarian whose true sensors stand elsewhere: by x, y, z in [m] and yaw in [rad]."""
    whole = BenchFrames._message

    def elsewhere(frames: BenchFrames, now: float, poses: dict[str, Transform], parent: str = "") -> object:
        off = {
            name: pose @ transform(moved[name][:3], (0.0, 0.0, moved[name][3])) if name in moved else pose
            for name, pose in poses.items()
        }
        return whole(frames, now, off, parent)

    monkeypatch.setattr(BenchFrames, "_message", elsewhere)
    robot = load_robot("librarian").without_errors()
    bench = LocalBench(robot, RosSpec(), KinematicBackend.build(robot, WORLD, 0))
    report = listen(robot, RosSpec(), bench.link, bench.step, 0.3)
    bench.close()
    return report


def test_sensors_where_the_file_has_them_are_no_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    report = report_of(monkeypatch, {})
    assert not report.faults
    assert not [remark for remark in report.remarks if "tf" in remark.words]


@pytest.mark.parametrize(
    ("sensor", "off", "words"),
    [
        ("range_sensor", (0.05, 0.0, 0.0, 0.0), "0.050 m and 0.0 deg from where the robot's file has it"),
        ("range_sensor", (0.0, 0.0, 0.0, math.pi), "0.000 m and 180.0 deg"),
        ("camera", (0.0, 0.0, 0.04, 0.1), "0.040 m and 5.7 deg"),
    ],
)
def test_a_sensor_elsewhere_is_told_with_its_distance(
    monkeypatch: pytest.MonkeyPatch, sensor: str, off: tuple[float, ...], words: str
) -> None:
    report = report_of(monkeypatch, {sensor: off})
    assert len(report.faults) == 1
    assert f"tf: the frame '{sensor}' of " in report.faults[0].words
    assert words in report.faults[0].words


def test_the_base_drives_by_the_odometry_of_tf(make: Make) -> None:
    with make("cart", **BY_FRAMES) as by_frames, make("cart") as by_topic:
        ways = []
        for backend in (by_frames, by_topic):
            base = backend.get(Base)  # type: ignore[type-abstract]
            assert base is not None
            for _ in range(30):
                base.drive(0.2, 0.3)
                backend.step()
            ways.append(base.wheel_travel())
        assert ways[0].left == pytest.approx(ways[1].left, abs=1e-9)
        assert ways[0].right == pytest.approx(ways[1].right, abs=1e-9)


@pytest.mark.parametrize("fault", ["silent", "old-stamps", "nan", "wrong-frame"])
def test_odometry_of_tf_that_lies_stops_the_robot(make: Make, fault: str) -> None:
    with make("cart", faults=(f"{fault}@tf@0.3",), **BY_FRAMES) as backend:
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        with pytest.raises(RobotFault, match=r"the odometry \(tf\)"):
            for _ in range(40):
                base.drive(0.1, 0.0)
                backend.step()


def test_a_tree_of_frames_finds_its_way() -> None:
    tree = FrameTree()
    message = new_message("tf2_msgs/TFMessage")
    for child, parent, x in (
        ("/laser", "/mast", 1.0),
        ("mast", "base_link", 2.0),
        ("base_link", "odom", 5.0),
    ):
        one = new_message("geometry_msgs/TransformStamped")
        one.child_frame_id, one.header.frame_id, one.transform.translation.x = child, parent, x
        message.transforms.append(one)
    turned = message.transforms[1].transform.rotation  # the mast, to the left
    turned.z, turned.w = math.sin(math.pi / 4), math.cos(math.pi / 4)
    tree.take(message)
    found = tree.pose("base_link", "laser")
    assert found is not None
    assert found[:3, 3] == pytest.approx([2.0, 1.0, 0.0])
    back = tree.pose("laser", "odom")
    assert back is not None
    assert back[:3, 3] == pytest.approx([-1.0, 7.0, 0.0])
    assert tree.pose("base_link", "elsewhere") is None
    message.transforms = message.transforms[:1]
    message.transforms[0].child_frame_id, message.transforms[0].header.frame_id = "base_link", "laser"
    tree.take(message)
    assert tree.pose("base_link", "laser") is None  # a circle
