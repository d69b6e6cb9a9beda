"""Topics within this process: a bench on them needs neither rclpy nor a clock."""

from __future__ import annotations

from collections import deque
from typing import Any

from typing_extensions import override

from handcart.backends.ros2.wire.goals import Accepts, GoalSender, TakesGoal
from handcart.backends.ros2.wire.ros_link import Link, Take, kept_messages

from .local_goals import LocalAction, LocalGoalSender
from .local_messages import new_message


class LocalAir:
    """Simulation of a ROS network within this process, with its topics, its actions and the time for message
    stamps.
    """

    def __init__(self) -> None:
        """Begin without topics, at a time of 1 s: a stamp of 0 means none."""
        self.latched: dict[str, dict[int, Any]] = {}
        """Last message of each publisher of a latched topic, by its number, for later subscribers."""
        self.time = 1.0
        """Time of the topics, in [s]."""
        self.listeners: dict[str, list[tuple[LocalLink, str, deque[Any]]]] = {}
        """Subscribers of each topic, with the type of their messages and the messages not received yet."""
        self.publishers: dict[str, list[tuple[LocalLink, str]]] = {}
        """Publishers of each topic, with the type of their messages."""
        self.actions: dict[str, tuple[LocalLink, LocalAction]] = {}
        """Actions by their names, each with the node that serves it."""


class LocalLink(Link):
    """Connection of one node to the topics within this process (`LocalAir`)."""

    def __init__(self, air: LocalAir, name: str) -> None:
        """Join; `name` is that of the node."""
        self.name = name
        self._air = air
        self._taking: list[tuple[deque[Any], Take]] = []

    @override
    def subscribe(self, kind: str, topic: str, take: Take, latched: bool = False) -> None:
        waiting: deque[Any] = deque(maxlen=kept_messages(kind))
        self._air.listeners.setdefault(topic, []).append((self, kind, waiting))
        self._taking.append((waiting, take))
        if latched:
            waiting.extend(self._air.latched.get(topic, {}).values())

    @override
    def publisher(self, kind: str, topic: str) -> Take:
        self._air.publishers.setdefault(topic, []).append((self, kind))

        def publish(message: Any) -> None:
            for _, taken, waiting in self._air.listeners.get(topic, ()):
                if taken == kind:
                    waiting.append(message)

        return publish

    @override
    def latched(self, kind: str, topic: str) -> Take:
        publish = self.publisher(kind, topic)
        kept = self._air.latched.setdefault(topic, {})
        number = len(self._air.publishers[topic])

        def keep(message: Any) -> None:
            kept[number] = message
            publish(message)

        return keep

    @override
    def message(self, kind: str) -> Any:
        return new_message(kind)

    @override
    def receive(self) -> None:
        for waiting, take in self._taking:
            while waiting:
                take(waiting.popleft())
        for served, action in list(self._air.actions.values()):
            if served is self:
                action.answer()

    @override
    def publishers(self, topic: str) -> list[str]:
        return [f"/{link.name} ({kind})" for link, kind in self._air.publishers.get(topic, ())]

    @override
    def subscribers(self, topic: str) -> int:
        return len(self._air.listeners.get(topic, ()))

    @override
    def listeners(self, topic: str) -> list[str]:
        return [f"/{link.name} ({kind})" for link, kind, _ in self._air.listeners.get(topic, ())]

    @override
    def mismatches(self, topic: str, is_command: bool) -> list[str]:
        return []

    @override
    def topics_of(self, kind: str) -> list[str]:
        ends = [*self._air.publishers.items()]
        ends += [
            (topic, [(link, taken) for link, taken, _ in listeners])
            for topic, listeners in self._air.listeners.items()
        ]
        return sorted({topic for topic, links in ends if any(item == kind for _, item in links)})

    @override
    def joints_of(self, controller: str) -> list[str]:
        return []

    @override
    def goal_sender(self, kind: str, name: str) -> GoalSender:
        return LocalGoalSender(kind, lambda: self._action(kind, name))

    def _action(self, kind: str, name: str) -> LocalAction | None:
        served = self._air.actions.get(name)
        return None if served is None or served[1].kind != kind else served[1]

    @override
    def serve_action(self, kind: str, name: str, accepts: Accepts, take: TakesGoal) -> None:
        self._air.actions[name] = self, LocalAction(kind, accepts, take)

    @override
    def action_servers(self, name: str) -> list[str]:
        served = self._air.actions.get(name)
        return [] if served is None else [f"/{served[0].name} ({served[1].kind})"]

    @override
    def actions_of(self, kind: str) -> list[str]:
        return sorted(name for name, (_, item) in self._air.actions.items() if item.kind == kind)

    @override
    def now(self) -> float:
        return self._air.time

    @override
    def clock(self) -> float:
        return self._air.time

    @override
    def close(self) -> None:
        for listeners in self._air.listeners.values():
            listeners[:] = [listener for listener in listeners if listener[0] is not self]
        for publishers in self._air.publishers.values():
            publishers[:] = [publisher for publisher in publishers if publisher[0] is not self]
        for name in [name for name, served in self._air.actions.items() if served[0] is self]:
            del self._air.actions[name]
