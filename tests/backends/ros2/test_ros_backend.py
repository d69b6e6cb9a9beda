"""A robot by topics: commands arrive, readings come back, and it never drives blind."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.backend import Backend, CommandError, RobotFault
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base, DriveCommand
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.ros2.bench.bench_faults import BenchFaults
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.on_the_air import DISCOVERY_S, await_robot
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.ros_errors import NotOnTheAir, RosFault, WrongRosSection
from handcart.backends.ros2.wire.sole_use import sole_use

from .conftest import Make


def drive(backend: RosBackend, seconds: float, speed: float = 0.2, turn: float = 0.0) -> None:
    """Drive for some seconds."""
    base = backend.get(Base)  # type: ignore[type-abstract]
    assert base is not None
    for _ in range(round(seconds / backend.period)):
        base.drive(speed, turn)
        backend.step()


def speed_of(backend: RosBackend) -> float:
    """Return how far the true base moves in the next period, in [m/s]."""
    assert backend.bench is not None
    before = backend.true_base()
    backend.bench.step()
    after = backend.true_base()
    assert before is not None and after is not None
    return after.distance(before) / backend.period


@pytest.mark.parametrize("turn", [0.0, 0.4, -0.4])
def test_travel_is_that_of_the_simulated_wheels(make: Make, turn: float) -> None:
    with make() as backend:
        drive(backend, 2.0, 0.2, turn)
        drive(backend, 0.1, 0.0)
        travel = backend.get(Base).wheel_travel()  # type: ignore[type-abstract,union-attr]
        inner = backend.inner.get(Base).wheel_travel()  # type: ignore[type-abstract,union-attr]
        assert travel.left == pytest.approx(inner.left, abs=1e-6)
        assert travel.right == pytest.approx(inner.right, abs=1e-6)
        assert travel.left + travel.right == pytest.approx(0.8, abs=0.02)


@pytest.mark.parametrize("is_upside_down", [False, True])
def test_a_scan_is_the_same_however_the_lidar_is_mounted(make: Make, is_upside_down: bool) -> None:
    with make("cart", ideal=True, lidar={"upside_down": is_upside_down}) as backend:
        scan = backend.get(RangeSensor).scan()  # type: ignore[type-abstract,union-attr]
        true = backend.inner.get(RangeSensor).scan()  # type: ignore[type-abstract,union-attr]
        assert scan.angles == pytest.approx(true.angles)
        assert scan.ranges == pytest.approx(true.ranges, rel=1e-5)
        assert np.ptp(true.ranges - true.ranges[::-1]) > 0.1  # otherwise nothing is shown


def test_a_command_lives_one_period(make: Make) -> None:
    with make() as backend:
        drive(backend, 1.0)
        for _ in range(40):  # ramps end
            backend.step()
        assert speed_of(backend) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("name", ["TwistStamped", "Twist"])
def test_both_kinds_of_speeds_are_sent(make: Make, name: str) -> None:
    with make(velocity={"type": name}) as backend:
        drive(backend, 1.0)
        assert speed_of(backend) == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize(
    "arm",
    [
        {},
        {"type": "Float64MultiArray"},
        {
            "controllers": {
                "lift": ("joint_1", "joint_2"),
                "rest": ("joint_6", "joint_5", "joint_4", "joint_3"),
            }
        },
    ],
)
def test_an_arm_follows_by_its_controllers(make: Make, arm: dict[str, object]) -> None:
    with make(arm=arm, names={"joint_2": "shoulder_lift"}, reversed=("joint_3",)) as backend:
        joints = backend.get(Arm)  # type: ignore[type-abstract]
        inner = backend.inner.get(Arm)  # type: ignore[type-abstract,union-attr]
        assert joints is not None and inner is not None
        begun = joints.joints()
        for step in range(1, 21):
            joints.move(begun + 0.01 * step * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0]))
            backend.step()
        backend.step()
        assert inner.command() - begun == pytest.approx(0.2 * np.array([1, -1, 1, -1, 1, -1]), abs=1e-3)
        assert joints.joints() == pytest.approx(inner.joints(), abs=1e-9)


def test_fingers_press_on_each_other_when_closed(make: Make) -> None:
    with make() as backend:
        gripper = backend.get(Gripper)  # type: ignore[type-abstract]
        assert gripper is not None
        for width, pressing in ((0.05, False), (0.0, True)):
            gripper.move(width)
            for _ in range(60):
                backend.step()
            assert gripper.width() == pytest.approx(width, abs=2e-3)
            assert gripper.closed_on_something() is pressing


def test_force_at_the_hand_comes_from_efforts(make: Make) -> None:
    with make(ideal=True) as backend:
        arm, inner = backend.get(Arm), backend.inner  # type: ignore[type-abstract]
        assert arm is not None
        backend.step()
        for force in ([0.0, 0.0, 0.0], [-20.0, 3.0, 8.0]):
            inner.scene.hand_force = np.array(force)  # type: ignore[union-attr]
            inner._arm._settled = True  # type: ignore[union-attr]  # what touches stays as it is
            backend.step()
            assert arm.hand_force() == pytest.approx(force, abs=0.5)


def test_scans_and_pictures_are_those_of_the_simulation(make: Make) -> None:
    with make() as backend:
        backend.step()
        scan = backend.get(RangeSensor).scan()  # type: ignore[type-abstract,union-attr]
        inner = backend.inner.get(RangeSensor).scan()  # type: ignore[type-abstract,union-attr]
        assert scan.ranges == pytest.approx(inner.ranges, rel=1e-6)
        assert scan.angles == pytest.approx(inner.angles)
        picture = backend.get(Camera).image()  # type: ignore[type-abstract,union-attr]
        assert np.array_equal(picture, backend.inner.get(Camera).image())  # type: ignore[type-abstract,union-attr]


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["silent", "frozen", "delayed", "old-stamps", "nan", "wrong-frame"])
@pytest.mark.parametrize("topic", ["odom", "joint_states"])
def test_a_topic_that_lies_stops_the_robot(make: Make, fault: str, topic: str) -> None:
    odometry = {"topic": "odom", "frame": "odom"}
    joints = {"topic": "joint_states", "frame": ""}
    with make(faults=(f"{fault}@{topic}@0.5",), odometry=odometry, joint_states=joints) as backend:
        with pytest.raises(RobotFault, match=topic):
            drive(backend, 3.0)
        assert backend.bench is not None
        backend.bench.step()
        assert backend.bench.speeds == DriveCommand()  # reported at once, not after a time-out
        for _ in range(40):
            backend.bench.step()
        assert speed_of(backend) == pytest.approx(0.0, abs=1e-6)
        with pytest.raises(RosFault, match=topic):
            backend.step()


def test_odometry_that_changes_its_frame_under_way_stops_the_robot(make: Make) -> None:
    refusal = pytest.raises(RobotFault, match=r"\(odom\).*its frame is 'nowhere'; allowed: 'odom'")
    with make(faults=("wrong-frame@odom@0.5",)) as backend, refusal:
        drive(backend, 3.0)


@pytest.mark.parametrize("fault", ["silent", "frozen", "delayed", "old-stamps", "nan", "wrong-frame"])
def test_a_lidar_that_lies_gives_no_scan(make: Make, fault: str) -> None:
    with make(faults=(f"{fault}@scan@0.5",)) as backend:
        drive(backend, 2.0)
        with pytest.raises(RobotFault, match=r"the lidar \(scan\)"):
            backend.get(RangeSensor).scan()  # type: ignore[type-abstract,union-attr]


@pytest.mark.parametrize("fault", ["doubled", "swapped"])
def test_messages_in_a_wrong_order_are_dropped_and_counted(make: Make, fault: str) -> None:
    with make(faults=(f"{fault}@odom@0.0",)) as backend:
        drive(backend, 2.0)
        drive(backend, 0.2, 0.0)
        travel = backend.get(Base).wheel_travel()  # type: ignore[type-abstract,union-attr]
        assert travel.left == pytest.approx(0.4, abs=0.04)
        assert backend.figures()["rejected_messages"]["odom"] >= 10


def test_odometry_that_jumps_stops_the_robot(make: Make) -> None:
    with make() as backend:
        drive(backend, 0.5)
        odometry = backend.bench._drivers._wheels  # type: ignore[union-attr]
        odometry.pose = odometry.pose._replace(x=odometry.pose.x + 3.0)
        with pytest.raises(RosFault, match=r"odometry \(odom\) jumps by 3\.0"):
            backend.step()


def test_a_second_master_under_way_stops_the_robot(make: Make) -> None:
    from handcart.backends.ros2.bench.local_air import LocalLink

    with make() as backend:
        drive(backend, 0.5)
        LocalLink(backend.bench.air, "teleop").publisher("geometry_msgs/Twist", "cmd_vel")  # type: ignore[union-attr]
        with pytest.raises(RosFault, match=r"cmd_vel: 2 nodes publish it .*teleop"):
            drive(backend, 2.0)


def test_a_master_discovered_late_is_named_before_anything_moves(make: Make) -> None:
    from handcart.backends.ros2.bench.local_air import LocalLink

    with make() as backend:
        bench = backend.bench
        assert bench is not None
        begun, other = bench.link.clock(), list[LocalLink]()

        def wait(seconds: float) -> None:
            bench.wait(seconds)
            if not other and bench.link.clock() - begun > 0.8 * DISCOVERY_S:
                other.append(LocalLink(bench.air, "teleop"))
                other[0].publisher("geometry_msgs/Twist", "cmd_vel")

        await_robot(backend._topics, bench.link, 5.0, wait)  # without time, it is not seen
        with pytest.raises(NotOnTheAir, match=r"cmd_vel: 2 nodes publish it .*teleop"):
            await_robot(backend._topics, bench.link, 5.0, wait, DISCOVERY_S)


def test_a_second_run_is_refused_before_its_node_is_a_rival(
    make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its node on `cmd_vel` would stop the first run."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    from handcart.backends.ros2 import ros_backend
    from handcart.backends.ros2.bench.local_air import LocalLink

    with make() as first:
        air = first.bench.air  # type: ignore[union-attr]
        monkeypatch.setattr(ros_backend, "RosLink", lambda *_: LocalLink(air, "second"))
        topics = "cmd_vel", "arm_controller/joint_trajectory", "gripper_controller/joint_trajectory"
        before = {topic: list(first._link.publishers(topic)) for topic in topics}
        with pytest.raises(NotOnTheAir) as refused:
            RosBackend(first._topics._robot)
        for topic in topics:
            assert f"{topic}: /handcart" in str(refused.value)
            assert first._link.publishers(topic) == before[topic]
        assert "is another run under way" in str(refused.value)
        drive(first, 2.0)


def test_one_program_at_a_time_commands_a_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its node may not be discovered for seconds."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    for _ in range(2):  # the first one's end releases it
        with sole_use("ROS domain 7, /"), sole_use("ROS domain 8, /"):
            second = sole_use("ROS domain 7, /")
            with pytest.raises(
                NotOnTheAir, match=f"process {os.getpid()} of this machine commands the robot"
            ):
                second.__enter__()


def test_drivers_that_are_gone_stop_the_robot(make: Make) -> None:
    with make() as backend:
        drive(backend, 0.5)
        backend.bench.air.listeners["cmd_vel"].clear()  # type: ignore[union-attr]
        with pytest.raises(RosFault, match="nobody listens to cmd_vel any more"):
            drive(backend, 2.0)


def test_all_that_is_missing_is_told_at_once(make: Make) -> None:
    with pytest.raises(NotOnTheAir) as refused:
        make(faults=("silent@odom@0", "nan@scan@0"), names={"joint_4": "joint_four"}, first_message_s=0.2)
    assert "the odometry (odom): /bench (nav_msgs/Odometry) publishes it, but no message" in str(
        refused.value
    )
    assert "its angles are not finite" in str(refused.value)


def test_a_joint_that_nobody_names_is_told_with_the_nearest(make: Make) -> None:
    with make() as backend:
        states = backend._topics.states
        assert states is not None
        states.expect(["joint_1", "joint_5x"], [1.0, 1.0])
        backend.step()
        assert "joint_states: no message has the joint 'joint_5x'" in states.missing
        assert "joint_5" in states.missing.partition("'joint_5x'")[2]


def test_joints_that_the_arm_lacks_are_told_all_at_once(make: Make) -> None:
    controllers = {"a": ("joint_1", "joint_2", "joint_2"), "b": ("jont_3", "joint_4", "joint_5", "joint_6")}
    with pytest.raises(WrongRosSection) as error:
        make(arm={"controllers": controllers}, names={"wrist": "x"}, reversed=("elbow",))
    for words in (
        "the arm has no joint 'jont_3'; did you mean 'joint_3'?",
        "names: the arm has no joint 'wrist'",
        "reversed: the arm has no joint 'elbow'",
        "arm: the joint 'joint_2' is named twice; allowed: once",
        "no controller has the joint 'joint_3'",
    ):
        assert words in str(error.value)


def test_a_joint_read_beyond_its_limits_is_refused(monkeypatch: pytest.MonkeyPatch, make: Make) -> None:
    """The bench has the sign that the file lacks: what both get wrong alike, neither would notice."""

    def reversed_bench(robot: RobotFile, _: RosSpec, inner: Backend, faults: BenchFaults) -> LocalBench:
        return LocalBench(robot, RosSpec(reversed=("joint_3",)), inner, faults)

    monkeypatch.setattr("tests.backends.ros2.conftest.LocalBench", reversed_bench)
    with pytest.raises(NotOnTheAir, match=r"'joint_3' is read at -2\.66 .* is its sign"):
        make()


@pytest.mark.parametrize("speed", [math.nan, math.inf, 50.0])
def test_no_senseless_speed_is_sent(make: Make, speed: float) -> None:
    with make() as backend, pytest.raises(CommandError):
        backend.get(Base).drive(speed, 0.0)  # type: ignore[type-abstract,union-attr]


@pytest.mark.parametrize(("limits", "jumps"), [({}, True), ({"jump_m": 1.0}, False)])
def test_a_jump_is_what_the_file_says(make: Make, limits: dict[str, object], jumps: bool) -> None:
    with make("cart", odometry={"topic": "odom", **limits}) as backend:
        drive(backend, 0.2)
        odometry = backend._topics.odometry
        stamp, pose = odometry._last  # type: ignore[misc]
        odometry._last = stamp, pose._replace(x=pose.x - 0.5)
        if jumps:
            with pytest.raises(RosFault, match=r"jumps by 0\.5. m"):
                drive(backend, 0.1)
        else:
            drive(backend, 0.1)


@pytest.mark.parametrize(("key", "presses"), [({}, True), ({"rest_ms": 3000.0}, False)])
def test_fingers_press_by_the_rule_of_the_file(make: Make, key: dict[str, object], presses: bool) -> None:
    with make(gripper=key) as backend:
        gripper = backend.get(Gripper)  # type: ignore[type-abstract]
        assert gripper is not None
        gripper.move(0.0)
        for _ in range(40):
            backend.step()
        assert gripper.closed_on_something() is presses
