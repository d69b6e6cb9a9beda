"""Comparison of a robot's file with the topics of a recorded bag."""

from __future__ import annotations

from pathlib import Path

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.ros2.air_check.air_finding import AirFinding
from handcart.backends.ros2.air_check.air_report import AirReport, listen

from .bag_link import BagLink

PASS_S = 0.01
"""Time of the recording between two checks for messages, in [s]."""


def recorded_report(robot: RobotFile, spec: RosSpec, path: Path, seconds: float) -> AirReport:
    """Play a recorded ROS bag, and report where its topics differ from the robot's file.

    Args:
        robot: the robot's file.
        spec: its section `ros2`.
        path: the bag.
        seconds: longest time of the recording to listen to, in [s].

    Raises:
        InputError: the extra `bags` is not installed.
        FileError: the bag cannot be read, or has no readings.
    """
    link = BagLink(path, spec.namespace)
    report = listen(robot, spec, link, lambda: link.pass_time(PASS_S), seconds, lambda: link.is_over)
    notes = tuple(AirFinding(("ros2",), f"{path}: {note}", is_fault=False) for note in link.notes)
    return report._replace(remarks=(*report.remarks, *notes))
