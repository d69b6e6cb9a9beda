"""Two nodes that send one quantity, less than a jump apart: odometry and frames by tf, joints."""

from __future__ import annotations

import math
import random
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.ros2.bench.bench_frames import BenchFrames
from handcart.backends.ros2.bench.local_air import LocalLink
from handcart.backends.ros2.bench.local_messages import new_message
from handcart.backends.ros2.wire.alternation import KEPT_READINGS, AlternationWatch
from handcart.backends.ros2.wire.frame_tree import FrameTree
from handcart.backends.ros2.wire.messages import set_stamp
from handcart.robotics.geometry.transform import transform

from .conftest import Make
from .test_ros_frames import BY_FRAMES

PERIOD = 0.05


def alternates(readings: list[tuple[float, float]], limit: float = 0.01) -> bool:
    """Return whether any of the readings, each a stamp in [s] and a value, is an alternation."""
    watch = AlternationWatch((limit,))
    return any(watch.note(stamp, (value,)) is not None for stamp, value in readings)


def driven(time: float) -> float:
    """Return the way in [m] of a base that drives to and fro at up to 0.6 m/s."""
    return 0.6 * math.sin(time)


@pytest.mark.parametrize("apart", [0.015, 0.05, 0.09])
@pytest.mark.parametrize("share", [1, 2, 5])
def test_two_senders_are_found_at_rest_and_while_driving(apart: float, share: int) -> None:
    """The second node sends each `share`-th time."""
    for way in (lambda _: 0.0, driven):
        readings = []
        for count in range(6 * KEPT_READINGS):
            time = PERIOD * count
            readings.append((time, way(time)))
            if count % share == 0:
                readings.append((time + 0.02, way(time + 0.02) + apart + (0.03 if way is driven else 0.0)))
        assert alternates(readings)


def test_one_sender_that_drives_is_not_found() -> None:
    rng = random.Random(1)
    exact = [(PERIOD * count, driven(PERIOD * count)) for count in range(400)]
    noisy = [(time, value + rng.gauss(0.0, 0.002)) for time, value in exact]
    late = [(time + rng.uniform(0.0, 0.049), value) for time, value in exact]
    bursts = [(time - (0.049 if count % 2 else 0.0), value) for count, (time, value) in enumerate(exact)]
    corrected = [(time, value + 0.03 * (count // 7)) for count, (time, value) in enumerate(exact)]
    stopping = [(time, min(value, 0.3)) for time, value in exact]
    for readings in (exact, noisy, late, bursts, corrected, stopping):
        assert not alternates(readings)


def test_single_spikes_and_values_that_wrap_are_not_found() -> None:
    spikes = [(PERIOD * count, 0.5 if count % 40 == 20 else 0.0) for count in range(400)]
    wrapped = [(PERIOD * count, math.pi * (-1) ** count) for count in range(400)]
    assert not alternates(spikes)
    assert not alternates(wrapped, limit=math.inf)
    assert alternates(wrapped)


def second_base(monkeypatch: pytest.MonkeyPatch, apart: float) -> None:
    """Let the bench send each frame of `tf` twice, the second time some metres ahead and a moment later."""
    whole = BenchFrames._message

    def doubled(frames: BenchFrames, now: float, poses: dict[str, Any], parent: str = "") -> Any:
        message = whole(frames, now, poses, parent)
        moved = {name: pose @ transform((apart, 0.0, 0.0), (0.0, 0.0, 0.0)) for name, pose in poses.items()}
        message.transforms = [*message.transforms, *whole(frames, now + 0.02, moved, parent).transforms]
        return message

    monkeypatch.setattr(BenchFrames, "_message", doubled)


@pytest.mark.parametrize("speed", [0.0, 0.3])
def test_two_nodes_that_send_the_odometry_by_tf_stop_it(
    make: Make, monkeypatch: pytest.MonkeyPatch, speed: float
) -> None:
    second_base(monkeypatch, 0.05)
    words = r"the odometry \(tf\) goes to and fro by 0.0[45]\d* m .* allowed: 0.01 m. Do two nodes send it\?"
    with make("cart", ideal=True, **BY_FRAMES) as backend, pytest.raises(RobotFault, match=words):
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        for _ in range(40):
            base.drive(speed, 0.0)
            backend.step()


def test_one_node_that_sends_the_odometry_by_tf_drives(make: Make) -> None:
    with make("cart", **BY_FRAMES) as backend:
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        for period in range(200):
            base.drive(0.3 if period % 40 < 20 else -0.3, 0.8)
            backend.step()


def test_two_nodes_that_send_a_joint_stop_it(make: Make) -> None:
    with make(ideal=True) as backend:
        states, bench = backend._topics.states, backend.bench
        assert states is not None and bench is not None
        publish = LocalLink(bench.air, "sliders").publisher("sensor_msgs/JointState", "joint_states")
        joint_2 = float(states.positions(["joint_2"])[0])
        with pytest.raises(RobotFault, match=r"the joint 'joint_2' goes to and fro by 0.04 .* two nodes"):
            for _ in range(40):
                backend.step()
                message = new_message("sensor_msgs/JointState")
                set_stamp(message.header, bench.air.time + 0.001)  # between two of the other one
                message.name = ["joint_2"]
                message.position = [joint_2 + 0.04]
                publish(message)


def test_a_frame_of_two_nodes_is_named() -> None:
    tree, one = FrameTree(), FrameTree()
    for count in range(20):
        for moment, x in ((0.0, 0.30), (0.02, 0.35)):
            message = moving_frame(count * PERIOD + moment, x)
            tree.take(message)
            if not moment:
                one.take(message)
                one.take(message)  # sent twice
    assert tree.conflicts("camera") == [
        "the frame 'camera' has poses in 'base' that go to and fro by 0.050 m"
    ]
    assert one.conflicts("camera") == []


def moving_frame(time: float, x: float) -> Any:
    """Return a message of `tf` with a camera's frame in the base at a time in [s]."""
    item = new_message("geometry_msgs/TransformStamped")
    item.header.frame_id, item.child_frame_id = "base", "camera"
    item.header.stamp = SimpleNamespace(sec=int(time), nanosec=round(1e9 * (time % 1.0)))
    item.transform.translation.x, item.transform.rotation.w = x, 1.0
    message = new_message("tf2_msgs/TFMessage")
    message.transforms = [item]
    return message
