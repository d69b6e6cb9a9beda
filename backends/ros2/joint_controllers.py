"""Controllers of joints: by a topic, or by goals of an action."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from typing_extensions import override

from .goal_stream import GoalStream
from .wire.messages import gripper_goal, joint_message, message_kind, trajectory_goal
from .wire.ros_link import Link


class JointController(Protocol):
    """Interface of a controller that takes positions of joints."""

    def send(self, names: Sequence[str], positions: Sequence[float], seconds: float) -> None:
        """Send positions.

        Args:
            names: names of the n joints in ROS.
            positions: (n,) in [rad] or [m].
            seconds: time in [s] in which they are to be reached.
        """

    def cancel(self) -> None:
        """Cancel the positions that were sent, if the controller can."""


class TopicController(JointController):
    """Controller that takes messages of a topic, and holds the last one."""

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
        """Do nothing: a point sent by a topic ends with its period."""


class TrajectoryController(JointController):
    """Controller that takes goals of `FollowJointTrajectory`, each of one point."""

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
    """Controller that takes goals of `GripperCommand`: one position for all fingers."""

    def __init__(self, stream: GoalStream, effort: float) -> None:
        """Send goals to a stream, with an effort in [N]."""
        self._stream, self._effort = stream, effort

    @override
    def send(self, names: Sequence[str], positions: Sequence[float], seconds: float) -> None:
        self._stream.send(gripper_goal(self._stream.sender, positions[0], self._effort))

    @override
    def cancel(self) -> None:
        self._stream.cancel()
