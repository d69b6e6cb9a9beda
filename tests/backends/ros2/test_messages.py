"""Sent messages consist of finite floats."""

import math

import numpy as np
import pytest

from handcart.backends.backend import CommandError
from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.description.ros_spec import RosVelocitySpec
from handcart.backends.ros2.bench.local_air import LocalAir, LocalLink
from handcart.backends.ros2.wire.messages import joint_message, set_stamp, velocity_message


@pytest.fixture
def link() -> LocalLink:
    return LocalLink(LocalAir(), "test")


@pytest.mark.parametrize("value", [1, True, np.float32(1.0), np.int64(1)])
def test_numbers_of_other_types_become_floats(link: LocalLink, value: float) -> None:
    message = velocity_message(link, RosVelocitySpec(), DriveCommand(value, value, value))
    for item in (message.linear.x, message.linear.y, message.angular.z):
        assert type(item) is float
        assert item == 1.0


@pytest.mark.parametrize("kind", ["JointTrajectory", "Float64MultiArray"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_no_infinite_number_is_sent(link: LocalLink, kind: str, value: float) -> None:
    with pytest.raises(CommandError, match="finite"):
        joint_message(link, kind, ["a"], [value], 0.05)


def test_a_point_is_due_at_the_end_of_the_period(link: LocalLink) -> None:
    message = joint_message(link, "JointTrajectory", ["a", "b"], [1, 2], 1.25)
    assert message.joint_names == ["a", "b"]
    assert message.points[0].positions == [1.0, 2.0]
    due = message.points[0].time_from_start
    assert (due.sec, due.nanosec) == (1, 250_000_000)


def test_a_stamp_has_whole_seconds_and_nanoseconds(link: LocalLink) -> None:
    header = link.message("sensor_msgs/Imu").header
    set_stamp(header, 12.5)
    assert (header.stamp.sec, header.stamp.nanosec) == (12, 500_000_000)
