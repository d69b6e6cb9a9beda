"""Connection that listens and measures, and never sends."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from handcart.backends.ros2.wire.goals import Accepts, GoalSender, SentGoal, TakesGoal
from handcart.backends.ros2.wire.ros_link import Link, Take

from .topic_meter import TopicMeter


class ListeningLink(Link):
    """Connection to ROS topics that measures all received messages for checks, and never publishes.

    It does not even announce a publisher, because a program that drives the robot at the same time would
    report a second sender of commands.
    """

    def __init__(self, link: Link) -> None:
        """Take a connection that the caller owns."""
        self._link, self.place = link, link.place
        self.meters: dict[str, TopicMeter] = {}
        """Measurement of each topic that is heard."""

    @override
    def subscribe(self, kind: str, topic: str, take: Take, latched: bool = False) -> None:
        meter = self.meters[topic] = TopicMeter(topic, kind, self.clock, self.now)

        def heard(message: Any) -> None:
            meter.heard(message)
            take(message)

        self._link.subscribe(kind, topic, heard, latched)

    def subscribe_unmeasured(self, kind: str, topic: str, take: Take, latched: bool = False) -> None:
        """Call `take` with each message of a topic, as `Link.subscribe` does, without measuring the rate and
        age of its messages.
        """
        self._link.subscribe(kind, topic, take, latched)

    @override
    def publisher(self, kind: str, topic: str) -> Take:
        def refuse(message: Any) -> None:
            raise AssertionError(f"a check would send to {topic}")

        return refuse

    @override
    def latched(self, kind: str, topic: str) -> Take:
        return self.publisher(kind, topic)

    @override
    def message(self, kind: str) -> Any:
        return self._link.message(kind)

    @override
    def receive(self) -> None:
        self._link.receive()

    @override
    def publishers(self, topic: str) -> list[str]:
        return self._link.publishers(topic)

    @override
    def subscribers(self, topic: str) -> int:
        return self._link.subscribers(topic)

    @override
    def listeners(self, topic: str) -> list[str]:
        return self._link.listeners(topic)

    @override
    def mismatches(self, topic: str, is_command: bool) -> list[str]:
        return self._link.mismatches(topic, is_command)

    @override
    def topics_of(self, kind: str) -> list[str]:
        return self._link.topics_of(kind)

    @override
    def joints_of(self, controller: str) -> list[str]:
        return self._link.joints_of(controller)

    @override
    def goal_sender(self, kind: str, name: str) -> GoalSender:
        return _SilentSender(self._link.goal_sender(kind, name), name)

    @override
    def serve_action(self, kind: str, name: str, accepts: Accepts, take: TakesGoal) -> None:
        raise AssertionError(f"a check would serve {name}")

    @override
    def action_servers(self, name: str) -> list[str]:
        return self._link.action_servers(name)

    @override
    def actions_of(self, kind: str) -> list[str]:
        return self._link.actions_of(kind)

    @override
    def now(self) -> float:
        return self._link.now()

    @override
    def clock(self) -> float:
        return self._link.clock()

    @override
    def close(self) -> None:
        self._link.close()


class _SilentSender(GoalSender):
    """Sender of an action's goals that never sends."""

    def __init__(self, sender: GoalSender, name: str) -> None:
        """Take the true sender, and the name of the action."""
        self._sender, self._name = sender, name

    @override
    def is_ready(self) -> bool:
        return self._sender.is_ready()

    @override
    def others_goal(self) -> bool:
        return self._sender.others_goal()

    @override
    def new_goal(self) -> Any:
        return self._sender.new_goal()

    @override
    def send(self, goal: Any) -> SentGoal:
        raise AssertionError(f"a check would send a goal to {self._name}")
