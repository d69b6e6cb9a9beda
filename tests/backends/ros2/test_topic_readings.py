"""Readings of drivers that count otherwise than the robot's file."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.description.ros_spec import RosTopicSpec
from handcart.backends.live.sensor_errors import StaleSensor
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.bench.local_messages import new_message
from handcart.backends.ros2.cameras.ros_camera import TO_GREY, grey_picture
from handcart.backends.ros2.joint_states import JointStates
from handcart.backends.ros2.ros_lidar import RosLidar


class Time:
    """A clock that the test sets."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def lidar_of(time: Time, is_upside_down: bool = False) -> RosLidar:
    """Return the cart's lidar, behind a topic."""
    spec = load_robot("cart").range_sensor
    assert spec is not None
    lidar = RosLidar("the lidar", RosTopicSpec(topic="scan"), time, time)
    lidar.fit(spec, np.eye(4), is_upside_down)
    return lidar


def scan_at(time: float, count: int = 360, start: float = -np.pi, step: float = 2 * np.pi / 360) -> Any:
    """Return a scan whose ranges are 1.00 m, 1.01 m, and so on."""
    scan = new_message("sensor_msgs/LaserScan")
    scan.header.stamp = SimpleNamespace(sec=int(time), nanosec=round(1e9 * (time % 1.0)))
    scan.angle_min, scan.angle_increment = start, step
    scan.ranges = [1.0 + 0.01 * index for index in range(count)]
    return scan


def test_a_lidar_that_counts_clockwise_is_turned_round() -> None:
    time = Time()
    lidar = lidar_of(time)
    step = 2 * np.pi / 360
    lidar.heard(scan_at(100.0, start=np.pi - step, step=-step))
    lidar.advance()
    assert lidar.scan().ranges[-1] == pytest.approx(1.0)
    assert lidar.scan().angles[0] == pytest.approx(-np.pi)


@pytest.mark.parametrize(("start_deg", "step_deg", "first"), [(-179.0, 1.0, -1), (180.0, -1.0, 0)])
def test_a_lidar_upside_down_counts_the_other_way(start_deg: float, step_deg: float, first: int) -> None:
    """The angle of a beam is that in the messages' frame, with the opposite sign."""
    time = Time()
    lidar = lidar_of(time, is_upside_down=True)
    lidar.heard(scan_at(100.0, start=np.radians(start_deg), step=np.radians(step_deg)))
    lidar.advance()
    assert not lidar.doubt
    scan = lidar.scan()
    assert scan.ranges[first] == pytest.approx(1.0)
    assert np.degrees(scan.angles[first]) == pytest.approx(-start_deg)


@pytest.mark.parametrize("count", [352, 359, 361, 370])
@pytest.mark.parametrize("clockwise", [False, True])
def test_scans_of_varying_length_are_read_at_the_files_angles(count: int, clockwise: bool) -> None:
    """A wall in front at 2 m, of a driver that spreads over the circle what a turn had."""
    time, step = Time(), 2 * np.pi / (count - 1)
    lidar = lidar_of(time)
    start, step = (np.pi, -step) if clockwise else (-np.pi, step)
    scan = scan_at(100.0, count, start, step)
    angles = start + step * np.arange(count)
    with np.errstate(divide="ignore"):
        scan.ranges = np.where(np.abs(angles) < 1.0, 2.0 / np.cos(angles), np.inf)
    lidar.heard(scan)
    lidar.advance()
    assert not lidar.doubt
    read = lidar.scan()
    seen = np.abs(read.angles) < 0.98
    assert read.ranges[seen] * np.cos(read.angles[seen]) == pytest.approx(2.0, abs=1e-3)
    assert np.isposinf(read.ranges[np.abs(read.angles) > 1.02]).all()


@pytest.mark.parametrize(
    ("scan", "words"),
    [
        (scan_at(100.0, 340), "340 beams; the robot's file says 360"),
        (scan_at(100.0, 359, start=-3.0), "its beams are at -171.9 to 186.1 deg"),
        (scan_at(100.0, step=0.0), "its angle_increment is 0"),
        (scan_at(100.0, start=-3.0), "its beams are at -171.9 to 187.1 deg"),
        (scan_at(0.0), "it has no stamp (0); needed: a driver that stamps its readings"),
        (scan_at(40.0), "its stamp is 60 s old; allowed: 0.3 s"),
        (scan_at(130.0), "its stamp is 30 s in the future"),
    ],
)
def test_a_scan_unlike_the_file_is_refused_with_its_reason(scan: Any, words: str) -> None:
    lidar = lidar_of(Time())
    lidar.heard(scan)
    lidar.advance()
    assert lidar.age is None
    assert words in lidar.doubt


def test_a_scan_is_the_same_object_until_the_next_arrives() -> None:
    """Callers detect a new scan by its identity: each is interpreted once and averaged once."""
    time = Time()
    lidar = lidar_of(time)
    lidar.heard(scan_at(100.0))
    lidar.advance()
    first = lidar.scan()
    time.now = 100.1
    lidar.advance()
    assert lidar.scan() is first
    lidar.heard(scan_at(100.1))
    lidar.advance()
    assert lidar.scan() is not first


def test_a_reading_is_one_of_now_until_it_is_stale() -> None:
    time = Time()
    lidar = lidar_of(time)
    lidar.heard(scan_at(100.0))
    for later, fresh in ((0.0, True), (0.29, True), (0.31, False)):
        time.now = 100.0 + later
        lidar.advance()
        assert (lidar.age is not None and lidar.age <= 0.3) is fresh


def test_joints_of_several_publishers_are_put_together() -> None:
    time = Time()
    states = JointStates("the joints", RosTopicSpec(topic="joint_states"), time, time)
    states.expect(["lift", "wrist"], [1.0, -1.0])
    for number, (name, position) in enumerate((("lift", 0.2), ("wrist", 0.3), ("head", 9.0))):
        message = new_message("sensor_msgs/JointState")
        message.header.stamp = SimpleNamespace(sec=100, nanosec=number)
        message.name, message.position = [name], [position]
        states.heard(message)
    states.advance()
    assert states.positions(["wrist", "lift"]).tolist() == [-0.3, 0.2]
    assert np.isnan(states.efforts(["lift"])).all()


def states_of(time: Time) -> JointStates:
    """Return the readings of two joints, which move by 1 rad/s at most."""
    states = JointStates("the joints", RosTopicSpec(topic="joint_states"), time, time)
    states.expect(["lift", "wrist"], [1.0, 1.0])
    states.limit(["lift", "wrist"], np.ones(2))
    return states


def hear(states: JointStates, time: Time, stamp: float, **positions: float) -> None:
    message = new_message("sensor_msgs/JointState")
    message.header.stamp = SimpleNamespace(sec=int(stamp), nanosec=round(1e9 * (stamp % 1.0)))
    message.name, message.position = list(positions), list(positions.values())
    states.heard(message)
    states.advance()


def test_publishers_with_different_delays_are_all_heard() -> None:
    time = Time()
    states = states_of(time)
    for step in range(10):
        time.now = 100.0 + 0.05 * step
        hear(states, time, time.now, lift=0.01 * step)
        hear(states, time, time.now - 0.06, wrist=0.02 * step)
    assert states.rejected == 0
    assert states.positions(["lift", "wrist"]) == pytest.approx([0.09, 0.18])
    hear(states, time, time.now, lift=0.5)
    assert states.rejected == 1


def test_a_joint_is_not_kept_fresh_by_the_publisher_of_others() -> None:
    time = Time()
    states = states_of(time)
    hear(states, time, 100.0, lift=0.0, wrist=0.0)
    for step in range(1, 9):
        time.now = 100.0 + 0.05 * step
        hear(states, time, time.now, lift=0.0)
    with pytest.raises(StaleSensor, match="no message has the joint 'wrist' any more"):
        states.positions(["lift"])
    hear(states, time, time.now, wrist=0.0)
    assert states.is_fresh


def test_two_publishers_that_contradict_each_other_are_noticed() -> None:
    time = Time()
    states = states_of(time)
    for step in range(5):
        time.now = 100.0 + 0.05 * step
        hear(states, time, time.now, lift=0.6 + 0.14 * step, wrist=0.0)
    assert not states.jumped
    hear(states, time, time.now + 0.001, lift=0.0, wrist=0.0)
    assert "joint_states: the joint 'lift' jumps by 1.16 rad or m in 0.001 s" in states.jumped


@pytest.mark.parametrize("encoding", TO_GREY)
def test_a_picture_of_each_encoding_becomes_grey(encoding: str) -> None:
    channels = TO_GREY[encoding][0]
    message = new_message("sensor_msgs/Image")
    message.height, message.width, message.encoding = 2, 3, encoding
    message.step = 3 * channels + 5  # rows are padded
    row = [200] * (3 * channels) + [7] * 5
    message.data = bytes(row * 2)
    grey = grey_picture(message)
    assert grey.shape == (2, 3)
    assert np.abs(grey.astype(int) - 200).max() <= 1
