"""Several nodes on one topic: lidars, static frames, joints; and goals of several nodes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.air_check.air_report import AirReport, listen
from handcart.backends.ros2.bench.local_air import LocalAir, LocalLink
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.bench.local_messages import new_message
from handcart.backends.ros2.ros_backend import DOUBLED_S, RosBackend
from handcart.backends.ros2.wire.frame_tree import FrameTree
from handcart.backends.ros2.wire.goals import RivalWatch
from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.ros_errors import NotOnTheAir

from .conftest import WORLD, Make

SCAN, FRAMES = "sensor_msgs/LaserScan", "tf2_msgs/TFMessage"


def second_lidar(bench: LocalBench, frame: str, ranges_m: float) -> Any:
    """Announce a second lidar on `scan`; return a function that publishes a scan of constant ranges."""
    publish = LocalLink(bench.air, "rear_lidar").publisher(SCAN, "scan")

    def scan() -> None:
        message = new_message(SCAN)
        message.header.frame_id = frame
        set_stamp(message.header, bench.air.time + 0.001)  # between two scans of the other one
        message.angle_min, message.angle_increment = -3.14159, 3.14159 / 180
        message.ranges = [ranges_m] * 360
        publish(message)

    return scan


def cart_with_two_lidars(second_frame: str, **lidar: object) -> RosBackend:
    """Return the cart by topics, whose bench has a second lidar in a frame."""
    robot = load_robot("cart").without_errors()
    spec = RosSpec(lidar={"topic": "scan", **lidar})  # type: ignore[arg-type]
    robot = robot.model_copy(update={"ros2": spec}).read_in(robot.folder)
    bench = LocalBench(robot, spec, KinematicBackend.build(robot, WORLD, 0))
    scan, whole = second_lidar(bench, second_frame, 0.5), bench.step

    def step() -> None:
        whole()
        scan()

    bench.step = step  # type: ignore[method-assign]
    bench.wait = lambda seconds: step()  # type: ignore[method-assign]
    return RosBackend(robot, bench)


@pytest.mark.parametrize("frame", ["range_sensor", "rear_lidar"])
def test_two_lidars_on_one_topic_are_refused_at_the_start(frame: str) -> None:
    words = (
        r"the lidar \(scan\): 2 nodes publish it \(/bench .*, /rear_lidar .*\); allowed: one, or its `frame`"
    )
    with pytest.raises(NotOnTheAir, match=words):
        cart_with_two_lidars(frame)


def test_a_named_frame_takes_one_of_two_lidars_on_a_topic() -> None:
    with cart_with_two_lidars("rear_lidar", frame="range_sensor") as backend:
        for _ in range(10):
            backend.step()
            ranges = backend.get(RangeSensor).scan().ranges  # type: ignore[type-abstract,union-attr]
            assert (ranges != 0.5).any()
        assert backend.figures()["rejected_messages"]["scan"] >= 10


@pytest.mark.parametrize("nodes_leave", [False, True])
def test_a_second_lidar_under_way_stops_unless_it_leaves(make: Make, nodes_leave: bool) -> None:
    """A driver that was killed and started again counts twice for up to 20 s."""
    with make("cart") as backend:
        base, bench = backend.get(Base), backend.bench  # type: ignore[type-abstract]
        assert base is not None and bench is not None
        other = LocalLink(bench.air, "bench")
        other.publisher(SCAN, "scan")

        def drive(seconds: float) -> None:
            for _ in range(round(seconds / backend.period)):
                base.drive(0.0, 0.1)
                backend.step()

        drive(21.0)
        if nodes_leave:
            other.close()
            drive(DOUBLED_S)
            return
        with pytest.raises(RobotFault, match=r"2 nodes publish it .* Was it started twice, or killed"):
            drive(DOUBLED_S)


def frame_message(child: str, parent: str, x: float) -> Any:
    """Return a message of `tf` with one frame, x in [m]."""
    message, one = new_message(FRAMES), new_message("geometry_msgs/TransformStamped")
    one.child_frame_id, one.header.frame_id, one.transform.translation.x = child, parent, x
    message.transforms = [one]
    return message


def report_with(frames: list[Any], late_s: float = 0.0) -> AirReport:
    """Check the cart while a second node publishes static frames, once each, after a time in [s]."""
    robot = load_robot("cart").without_errors()
    bench = LocalBench(robot, RosSpec(), KinematicBackend.build(robot, WORLD, 0))
    begun, waiting = bench.air.time, list(frames)

    def wait() -> None:
        bench.step()
        if bench.air.time - begun >= late_s:
            while waiting:
                LocalLink(bench.air, "calibration").latched(FRAMES, "tf_static")(waiting.pop(0))

    report = listen(robot, RosSpec(), bench.link, wait, 0.5)
    bench.close()
    return report


@pytest.mark.parametrize(
    ("parent", "x", "words"),
    [
        ("base_link", 5.0, "the frame 'range_sensor' has two static poses in 'base_link'"),
        ("mast", 0.0, "the frame 'range_sensor' has two parents, 'base_link' and 'mast'"),
    ],
)
def test_a_static_frame_published_twice_is_a_fault(parent: str, x: float, words: str) -> None:
    report = report_with([frame_message("/range_sensor", parent, x)], 0.2)
    assert any(words in fault.words for fault in report.faults), report.faults
    again = report_with([frame_message("elsewhere", parent, x), frame_message("elsewhere", parent, x + 1.0)])
    assert not again.faults  # no sensor depends on it


def test_a_static_frame_that_is_repeated_or_late_is_no_fault() -> None:
    tree = FrameTree()
    for message in (frame_message("laser", "base_link", 0.2), frame_message("/laser", "base_link", 0.2)):
        tree.take_static(message)
    assert tree.conflicts("laser") == []
    tree.take(frame_message("base_link", "odom", 1.0))
    tree.take(frame_message("base_link", "odom", 2.0))
    assert tree.conflicts("laser") == []
    tree.take(frame_message("base_link", "map", 2.0))
    assert tree.conflicts("/laser") == ["the frame 'base_link' has two parents, 'odom' and 'map'"]


def test_static_frames_of_many_nodes_all_arrive() -> None:
    air = LocalAir()
    for number in range(30):
        LocalLink(air, f"static_{number}").latched(FRAMES, "tf_static")(
            frame_message(f"frame_{number}", "base_link", 0.1)
        )
    tree, link = FrameTree(), LocalLink(air, "check")
    link.subscribe(FRAMES, "tf_static", tree.take_static, latched=True)
    link.receive()
    assert len(tree.frames) == 30


def test_a_fast_publisher_of_joints_does_not_push_out_a_slow_one() -> None:
    air, heard = LocalAir(), list[str]()
    link, arm = LocalLink(air, "program"), LocalLink(air, "arm").publisher("sensor_msgs/JointState", "j")
    hand = LocalLink(air, "hand").publisher("sensor_msgs/JointState", "j")
    link.subscribe("sensor_msgs/JointState", "j", lambda message: heard.append(message.name[0]))
    hand(SimpleNamespace(name=["finger"]))
    for _ in range(25):  # 500 Hz in a period of 50 ms
        arm(SimpleNamespace(name=["shoulder"]))
    link.receive()
    assert heard.count("finger") == 1


def states(names: list[bytes], state: int) -> dict[bytes, int]:
    return dict.fromkeys(names, state)


def test_own_goals_are_recognized_however_long_a_server_lists_them() -> None:
    rivals, ended, active = RivalWatch(), 6, 2
    before = states([bytes([number] * 16) for number in range(3)], ended)
    rivals.take(before)
    own = [rivals.new_id() for _ in range(5000)]  # 250 s of goals; a server of Humble lists 900 s of them
    assert len(set(own)) == len(own) and {len(name) for name in own} == {16}
    rivals.take({**before, **states(own, ended)})
    assert not rivals.has_found
    rivals.take(states(own[-1:], active))  # a controller that was restarted lists none of before
    assert not rivals.has_found
    rivals.take({**states(own[-1:], active), bytes(range(16)): ended})
    assert rivals.has_found
