"""Errors of a robot that speaks ROS 2.

    HandcartError
    ├── InputError
    │   ├── NoTopics            the robot's file has no section `ros2`
    │   ├── WrongRosSection     the section has faults, such as joints that the arm lacks
    │   ├── NoRos               rclpy is not installed
    │   └── NotOnTheAir         topics are missing, or are not what the file says: nothing has moved
    └── RobotFault
        └── RosFault            the robot is stopped, and stays so

After a `RosFault` a person has to look; the backend has to be built anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from handcart.backends.backend import RobotFault
from handcart.files.errors import InputError
from handcart.files.shown_path import shown_path

UNPUBLISHED = ("control_msgs", "tf2_msgs", "nav2_msgs", "moveit_msgs")
"""Packages of messages that no registry of Python packages has."""


class NoTopics(InputError):
    """Error: the robot's file has no section `ros2` with the robot's topics."""

    def __init__(self, folder: Path) -> None:
        super().__init__(
            f"the robot's file in {shown_path(folder)} has no section 'ros2';"
            " allowed: `ros2: {}` for the usual topics"
        )


class WrongRosSection(InputError):
    """Error: the section `ros2` names joints that the arm lacks, has a joint without a controller, or does
    not fit the robot's sensors.
    """

    def __init__(self, findings: Sequence[str]) -> None:
        super().__init__("\n".join(findings))


class NoRos(InputError):
    """Error: a Python package of ROS 2 is not installed."""

    def __init__(self, missing: ImportError) -> None:
        super().__init__(
            f"ROS 2 needs the package {missing.name or missing!r}; on a robot it belongs to its"
            " ROS distribution (`source /opt/ros/DISTRIBUTION/setup.bash`), elsewhere:"
            f" {_elsewhere(missing.name or '')}"
        )


def _elsewhere(package: str) -> str:
    """Return how to get a package on a machine without a ROS distribution."""
    if package.partition(".")[0] in UNPUBLISHED:
        return "it is to be built from its definitions, because no wheel of it is published"
    return "pip install 'handcart[ros2]'"


class NotOnTheAir(InputError):
    """Error: ROS topics are missing or differ from the robot's file; found before anything has moved."""

    def __init__(self, findings: Sequence[str]) -> None:
        self.findings = tuple(findings)
        super().__init__("\n".join(self.findings))


class RosFault(RobotFault):
    """Error: the robot was stopped; messages are missing or implausible, or another node commands it."""
