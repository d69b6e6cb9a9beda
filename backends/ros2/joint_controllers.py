"""Controllers of joints: by a topic, or by goals of an action."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from typing_extensions import override

from .goal_stream import GoalStream
from .wire.messages import gripper_goal, joint_message, message_kind, trajectory_goal
from .wire.ros_link import Link


class JointController(Protocol):
    """Interface of a ROS controller that moves joints to commanded positions."""

    def send(self, names: Sequence[str], positions: Sequence[float], seconds: float) -> None:
        """Command joint positions to the controller.

        Args:
            names: names of the n joints in ROS.
            positions: (n,) in [rad] or [m].
            seconds: time in which the joints have to reach the positions, in [s].
        """

    def cancel(self) -> None:
        """Cancel the motion to the positions that were sent last, if the controller can cancel it."""


class TopicController(JointController):
    """ROS controller that is commanded by messages on a topic; it holds the position of the last message."""

    def __init__(self, link: Link, kind: str, topic: str) -> None:
        """Announce the topic of a controller.

        Args:
            link: connection to the topics.
            kind: type of the messages, `JointTrajectory` or `Float64MultiArray`.
            topic: name of the topic.
        """
        self._link, self._kind = link, kind
        self._publish = link.publisher(message_kind(kind), topic)

    @override
    def send(self, names: Sequence[str], positions: Sequence[float], seconds: float) -> None:
        self._publish(joint_message(self._link, self._kind, names, positions, seconds))

    @override
    def cancel(self) -> None:
        """Do nothing, because the motion to the last commanded position ends with the control period."""


class TrajectoryController(JointController):
    """Arm controller that is commanded by goals of the ROS action `FollowJointTrajectory`, each with one
    trajectory point.
    """

    def __init__(self, link: Link, stream: GoalStream) -> None:
        """Send goals to a stream."""
        self._link, self._stream = link, stream

    @override
    def send(self, names: Sequence[str], positions: Sequence[float], seconds: float) -> None:
        self._stream.send(trajectory_goal(self._link, self._stream.sender, names, positions, seconds))

    @override
    def cancel(self) -> None:
        self._stream.cancel()


class FingerController(JointController):
    """Gripper controller that is commanded by goals of the action `GripperCommand`.

    A goal has one position for all fingers.
    """

    def __init__(self, stream: GoalStream, effort: float) -> None:
        """Send goals to a stream, with an effort in [N]."""
        self._stream, self._effort = stream, effort

    @override
    def send(self, names: Sequence[str], positions: Sequence[float], seconds: float) -> None:
        self._stream.send(gripper_goal(self._stream.sender, positions[0], self._effort))

    @override
    def cancel(self) -> None:
        self._stream.cancel()
