"""Listening to all topics of a robot's file for some seconds."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.ros2.on_the_air import empty_air
from handcart.backends.ros2.ros_topics import RosTopics, check_ros_section
from handcart.backends.ros2.wire.ros_link import Link

from .air_finding import AirFinding
from .command_findings import command_findings
from .frame_findings import frame_findings
from .heard_robot import HeardRobot
from .listening_link import ListeningLink
from .reading_findings import reading_findings
from .sensor_findings import sensor_findings
from .topic_meter import MeasuredTopic

DEFAULT_SECONDS = 5.0


class AirReport(NamedTuple):
    """Result of comparing the ROS topics of a running robot with the robot's file."""

    topics: tuple[MeasuredTopic, ...]
    nodes: dict[str, list[str]]
    """Nodes that publish or take each topic, by its name."""
    faults: tuple[AirFinding, ...]
    remarks: tuple[AirFinding, ...]
    """Findings that do not prevent a run."""


def listen(
    robot: RobotFile,
    spec: RosSpec,
    link: Link,
    wait: Callable[[], None],
    seconds: float = DEFAULT_SECONDS,
    over: Callable[[], bool] | None = None,
) -> AirReport:
    """Listen to a robot at rest, and compare it with its file; nothing is sent.

    Args:
        robot: the robot's file.
        spec: section `ros2` of that file.
        link: connection to the robot's topics.
        wait: function that waits for a short time, well below the period of a sensor.
        seconds: time to listen, in [s], after each topic has had a message or the wait for one has ended.
        over: function that returns True once a recording, which the messages come from and in which the robot
            may drive, has ended; None: the messages come from a robot at rest.

    Raises:
        WrongRosSection: the section has faults (`ros_faults`), such as joints that the arm lacks.
        NoRos: a package is not installed.
    """
    check_ros_section(robot, spec)
    ears = ListeningLink(link)
    heard = HeardRobot(robot, spec, RosTopics(robot, spec, ears), ears, over)
    heard.wait_for_all(wait, spec.first_message_s)
    heard.measure(wait, seconds)
    nowhere = empty_air(heard.topics, link)
    found = [
        *([AirFinding(("ros2",), nowhere)] if nowhere else []),
        *reading_findings(heard),
        *command_findings(heard),
        *sensor_findings(heard),
        *frame_findings(heard),
    ]
    topics = tuple(meter.measured() for meter in ears.meters.values())
    names = [*ears.meters, *heard.topics.commands]
    nodes = {
        name: link.listeners(name) if name in heard.topics.commands else link.publishers(name)
        for name in names
    }
    nodes |= {stream.name: link.action_servers(stream.name) for stream in heard.topics.streams}
    return AirReport(
        topics,
        nodes,
        tuple(item for item in found if item.is_fault),
        tuple(item for item in found if not item.is_fault),
    )
