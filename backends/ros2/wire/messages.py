"""Messages that are sent: every number is a finite float."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from handcart.backends.backend import CommandError
from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.description.ros_spec import RosVelocitySpec

from .goals import GoalSender
from .ros_link import Link

NO_FIX = -1
"""`status.status` of a `NavSatFix` without a fix."""
TRAJECTORY_ACTION, GRIPPER_ACTION = "control_msgs/FollowJointTrajectory", "control_msgs/GripperCommand"
URDF_TOPIC, SRDF_TOPIC = "robot_description", "robot_description_semantic"
"""Topics by which a robot describes itself, latched."""


def message_kind(kind: str) -> str:
    """Return a joint command's message type with its package, such as `std_msgs/Float64MultiArray`.

    Args:
        kind: `JointTrajectory` or `Float64MultiArray`.
    """
    return f"{'trajectory_msgs' if kind == 'JointTrajectory' else 'std_msgs'}/{kind}"


def velocity_message(link: Link, spec: RosVelocitySpec, command: DriveCommand) -> Any:
    """Return a command as a `Twist`, or as a `TwistStamped` with the present time of ROS as its stamp.

    Args:
        link: connection to the topics, which creates the message.
        spec: type and frame of the message.
        command: speeds forward and to the left in [m/s], turn rate to the left in [rad/s].
    """
    message = link.message(f"geometry_msgs/{spec.type}")
    twist = message
    if spec.type == "TwistStamped":
        twist = message.twist
        message.header.frame_id = spec.frame
        set_stamp(message.header, link.now())
    twist.linear.x, twist.linear.y = sound(command.speed), sound(command.sideways)
    twist.angular.z = sound(command.turn_rate)
    return message


def joint_message(
    link: Link, kind: str, names: Sequence[str], positions: Sequence[float], seconds: float
) -> Any:
    """Return a message that commands positions to a joint controller.

    Args:
        link: connection to the topics, which creates the message.
        kind: `JointTrajectory` or `Float64MultiArray`.
        names: names of the n joints in ROS.
        positions: (n,) in [rad] or [m].
        seconds: time in [s] in which a trajectory's point is to be reached.
    """
    message = link.message(message_kind(kind))
    values = [sound(position) for position in positions]
    if kind == "Float64MultiArray":
        message.data = values
        return message
    _set_point(link, message, names, values, seconds)
    return message


def trajectory_goal(
    link: Link, sender: GoalSender, names: Sequence[str], positions: Sequence[float], seconds: float
) -> Any:
    """Return a goal of `FollowJointTrajectory` with one point.

    Args:
        link: connection to the topics, which creates the point's message.
        sender: client of the action, which creates the goal.
        names: names of the n joints in ROS.
        positions: (n,) in [rad] or [m].
        seconds: time in [s] in which the point is to be reached.
    """
    goal = sender.new_goal()
    _set_point(link, goal.trajectory, names, [sound(position) for position in positions], seconds)
    return goal


def gripper_goal(sender: GoalSender, position: float, effort: float) -> Any:
    """Return a goal of `GripperCommand`: a position in [rad] or [m], and the largest effort in [N]."""
    goal = sender.new_goal()
    goal.command.position, goal.command.max_effort = sound(position), sound(effort)
    return goal


def _set_point(link: Link, message: Any, names: Sequence[str], values: list[float], seconds: float) -> None:
    """Make `message` a `JointTrajectory` of one point; without a stamp it begins when it arrives.

    Args:
        link: makes the point's message.
        message: message that is filled.
        names: names of the n joints in ROS.
        values: (n,) positions in [rad] or [m].
        seconds: time from the beginning in which the point is to be reached, in [s].
    """
    point = link.message("trajectory_msgs/JointTrajectoryPoint")
    point.positions = values
    whole = math.floor(seconds)
    point.time_from_start.sec, point.time_from_start.nanosec = int(whole), int(1e9 * (seconds - whole))
    message.joint_names, message.points = list(names), [point]


def set_stamp(header: Any, seconds: float) -> None:
    """Set the stamp of a `std_msgs/Header` to a time of ROS in [s]."""
    whole = math.floor(seconds)
    header.stamp.sec, header.stamp.nanosec = int(whole), int(1e9 * (seconds - whole))


def sound(value: float) -> float:
    """Return a finite number as a Python float; for values of other types, ROS sends wrong numbers without an
    error.

    Raises:
        CommandError: the number is not finite.
    """
    number = float(value)
    if not math.isfinite(number):
        raise CommandError(f"{value!r} would be sent; allowed: finite numbers")
    return number
