"""Topics of a recorded bag: its messages arrive as they did when they were recorded."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from typing_extensions import override

from handcart.backends.ros2.air_check.air_description import COMMAND_KINDS, READING_KINDS
from handcart.backends.ros2.bench.local_messages import new_goal, new_message
from handcart.backends.ros2.wire.goals import Accepts, GoalSender, SentGoal, TakesGoal
from handcart.backends.ros2.wire.ros_link import Link, Take, kept_messages
from handcart.evaluation.offline_localization.bags.bag_messages import BagError, BagMessage, read_bag
from handcart.files.errors import FileError, Finding, InputError
from handcart.files.extras import lack

NODE = "bag"
ROUNDING_S = 1e-6
READ_KINDS = (*READING_KINDS, "std_msgs/String", "tf2_msgs/TFMessage")


class BagLink(Link):
    """Connection to the topics of a recorded ROS bag instead of a robot; it discards commands.

    Its clock is that of the recording; `pass_time` advances it.
    """

    def __init__(self, path: Path, namespace: str = "") -> None:
        """Read a bag.

        Args:
            path: a folder of rosbag2, or a .mcap, .db3 or .bag file.
            namespace: namespace of topics that are requested by a relative name.

        Raises:
            InputError: the extra `bags` is not installed.
            FileError: the bag can't be read, or has no readings.
        """
        if (missing := lack("a ROS bag", "bags")) is not None:
            raise InputError(missing)
        try:
            bag = read_bag(path, {read_kind.replace("/", "/msg/") for read_kind in READ_KINDS})
        except BagError as error:
            raise FileError([Finding(str(path), 0, 0, str(error))]) from None
        if not bag.messages:
            raise FileError([Finding(str(path), 0, 0, f"no readings; it has {', '.join(bag.topics)}")])
        self.notes = tuple(bag.notes)
        """Messages about faults of the bag itself."""
        self._kinds = {topic: kind.replace("/msg/", "/") for topic, kind in bag.topics.items()}
        self._namespace = namespace
        self._messages = sorted(bag.messages, key=lambda message: message.received)
        self._next, self._time = 0, self._messages[0].received
        self._takes: dict[str, list[Take]] = {}

    @property
    def is_over(self) -> bool:
        """True once all messages of the recording have been delivered."""
        return self._next >= len(self._messages)

    def pass_time(self, seconds: float) -> None:
        """Advance the recording's clock by a time in [s]; `receive` then delivers the messages until then."""
        self._time += seconds

    @override
    def subscribe(self, kind: str, topic: str, take: Take, latched: bool = False) -> None:
        full = self._full(topic)
        if self._kinds.get(full) != kind:
            return
        self._takes.setdefault(full, []).append(take)
        if latched:
            before = [message for message in self._messages[: self._next] if message.topic == full]
            self._hand_over(before[-kept_messages(kind) :])  # a bag does not record who published each

    @override
    def receive(self) -> None:
        arrived = self._next
        while not self.is_over and self._messages[self._next].received <= self._time + ROUNDING_S:
            self._next += 1
        self._hand_over(self._messages[arrived : self._next])

    def _hand_over(self, messages: Iterable[BagMessage]) -> None:
        for message in messages:
            for take in self._takes.get(message.topic, ()):
                take(message.content)

    @override
    def publisher(self, kind: str, topic: str) -> Take:
        return lambda message: None

    @override
    def latched(self, kind: str, topic: str) -> Take:
        return self.publisher(kind, topic)

    @override
    def message(self, kind: str) -> Any:
        return new_message(kind)

    @override
    def publishers(self, topic: str) -> list[str]:
        kind = self._kinds.get(self._full(topic), "")
        return [f"/{NODE} ({kind})"] if kind and kind not in COMMAND_KINDS else []

    @override
    def subscribers(self, topic: str) -> int:
        return 0

    @override
    def listeners(self, topic: str) -> list[str]:
        return [f"/{NODE} ({kind})" for kind in COMMAND_KINDS]  # a bag does not record the listeners

    @override
    def mismatches(self, topic: str, is_command: bool) -> list[str]:
        return []

    @override
    def topics_of(self, kind: str) -> list[str]:
        return sorted(topic for topic, item in self._kinds.items() if item == kind)

    @override
    def joints_of(self, controller: str) -> list[str]:
        return []

    @override
    def goal_sender(self, kind: str, name: str) -> GoalSender:
        return _NoController(kind)

    @override
    def serve_action(self, kind: str, name: str, accepts: Accepts, take: TakesGoal) -> None:
        raise AssertionError(f"a bag would serve {name}")

    @override
    def action_servers(self, name: str) -> list[str]:
        return []

    @override
    def actions_of(self, kind: str) -> list[str]:
        return []

    @override
    def now(self) -> float:
        return self._time

    @override
    def clock(self) -> float:
        return self._time

    @override
    def close(self) -> None:
        """Drop all subscriptions."""
        self._takes = {}

    def _full(self, topic: str) -> str:
        return topic if topic.startswith("/") else f"{self._namespace}/{topic}"


class _NoController(GoalSender):
    """Goal sender of an action whose server a bag does not have."""

    def __init__(self, kind: str) -> None:
        """Create a sender for goals of an action of type `kind`; a bag can't take any goal."""
        self._kind = kind

    @override
    def is_ready(self) -> bool:
        return True

    @override
    def others_goal(self) -> bool:
        return False

    @override
    def new_goal(self) -> Any:
        return new_goal(self._kind)

    @override
    def send(self, goal: Any) -> SentGoal:
        raise AssertionError("a goal would be sent to a bag")
