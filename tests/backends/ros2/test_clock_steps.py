"""Clocks that are set under way: by NTP, by hand, on this machine or on the robot's."""

from __future__ import annotations

from typing import Any

import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.description.ros_spec import RosTopicSpec
from handcart.backends.live.sensor_errors import StaleSensor
from handcart.backends.ros2.bench.local_messages import new_message
from handcart.backends.ros2.cameras.ros_depth_camera import PictureTopic, stamp_of
from handcart.backends.ros2.joint_states import JointStates
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.clock_steps import ClockSteps
from handcart.backends.ros2.wire.messages import set_stamp

from .conftest import Make


def drive_with_clock(backend: RosBackend, step_s: float, drivers_step_s: float) -> None:
    """Drive while the clocks of this machine and of the drivers are set by a time in [s]."""
    assert backend.bench is not None
    base, air = backend.get(Base), backend.bench.air  # type: ignore[type-abstract]
    assert base is not None

    def late_stamps(take: Any) -> Any:
        def taken(message: Any) -> None:
            set_stamp(message.header, stamp_of(message) + drivers_step_s)
            take(message)

        return taken

    for period in range(40):
        if period == 10:
            for sensor in backend._topics.sensors:
                steps = sensor._clock_steps
                if sensor._stamps is not None and steps is not None:
                    sensor._stamps = steps._stamps = lambda: air.time + step_s
            taking = backend.bench.link._taking
            taking[:] = [(waiting, late_stamps(take)) for waiting, take in taking]
        base.drive(0.2, 0.0)
        backend.step()


@pytest.mark.parametrize("step_s", [-5.0, 5.0, -3600.0])
def test_a_clock_set_on_this_machine_leaves_its_drivers_fresh(make: Make, step_s: float) -> None:
    with make("cart") as backend:
        drive_with_clock(backend, step_s, step_s)
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        assert base.wheel_travel().left == pytest.approx(0.4, abs=0.05)


@pytest.mark.parametrize(
    ("step_s", "drivers_s", "words"),
    [
        (-5.0, 0.0, r"\(odom\).*s in the future.*the clock of this machine was set back by 5 s"),
        (5.0, 0.0, r"\(odom\).*s old.*the clock of this machine was set forward by 5 s"),
        (0.0, -5.0, r"\(odom\).*s old.*do the clocks of the robot and of this machine agree \(NTP\)"),
        (0.0, 5.0, r"\(odom\).*in the future.*do the clocks of the robot and of this machine agree"),
    ],
)
def test_a_clock_set_on_one_machine_is_named(make: Make, step_s: float, drivers_s: float, words: str) -> None:
    with make("cart") as backend, pytest.raises(RobotFault, match=words):
        drive_with_clock(backend, step_s, drivers_s)


def test_a_robots_clock_set_back_is_named_without_the_same_clock(make: Make) -> None:
    words = r"4.7 s before that of the message before; was the clock that stamps it set back"
    with make("cart", same_clock=False) as backend, pytest.raises(RobotFault, match=words):
        drive_with_clock(backend, 0.0, -5.0)


def test_a_clock_step_is_neither_slewing_nor_a_pause() -> None:
    now, offset, pause = 0.0, 1000.0, 0.0

    def monotonic() -> float:
        nonlocal now
        now += pause
        return now

    steps = ClockSteps(lambda: now + offset, monotonic)
    for _ in range(100):
        now, offset = now + 0.05, offset + 0.05 * 5e-4
        assert steps.advance() == 0.0
    pause = 0.3  # the program has no core between two readings
    assert steps.advance() == 0.0
    pause = 0.0
    assert steps.advance() == 0.0
    offset -= 2.0
    assert steps.advance() == pytest.approx(-2.0)
    assert steps.advance() == 0.0


def test_joints_and_pictures_follow_a_clock_that_is_set() -> None:
    now, offset = 100.0, 0.0
    states = JointStates("the joints", RosTopicSpec(topic="j"), lambda: now + offset, lambda: now)
    states.expect(["lift"], [1.0])
    pictures = PictureTopic("the depth", RosTopicSpec(topic="d"), lambda: now + offset, lambda: now)
    pictures.fit(1, 1, {"16UC1": 2})

    def hear(position: float) -> None:
        state, picture = new_message("sensor_msgs/JointState"), new_message("sensor_msgs/Image")
        state.name, state.position = ["lift"], [position]
        picture.encoding, picture.width, picture.height, picture.step = "16UC1", 1, 1, 2
        picture.data = bytes(2)
        for sensor, message in ((states, state), (pictures, picture)):
            set_stamp(message.header, now + offset)
            sensor.heard(message)
            sensor.advance()

    hear(0.1)
    now, offset = now + 0.05, -60.0
    hear(0.2)
    assert not states.doubt and not pictures.doubt
    assert [stamp_of(item) for item in pictures.kept] == pytest.approx([40.0, 40.05])
    assert states.positions_at(["lift"], 100.0).tolist() == [0.2]  # 0.1 was noted by the former time
    now += 1.0
    states.advance()
    with pytest.raises(StaleSensor):
        states.positions(["lift"])
