"""A link to ROS 2 that notes published messages, for tests without rclpy."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from typing_extensions import override

from handcart.backends.ros2.wire.ros_link import Take
from handcart.backends.ros2.wire.serving_link import Answer, ServingLink


class Fields:
    """Message of any type: a field that was not set is a message itself."""

    def __init__(self, kind: str = "") -> None:
        self.kind = kind

    def __getattr__(self, name: str) -> Fields:
        if name.startswith("__"):
            raise AttributeError(name)
        made = Fields()
        setattr(self, name, made)
        return made


class NotedLink(ServingLink):
    """Keeps all messages by topic, and all services by name."""

    def __init__(self, others: int = 0) -> None:
        """`others`: how many nodes offer the same services."""
        self.sent: dict[str, list[Any]] = {}
        self.services: dict[str, Callable[[], Answer]] = {}
        self.apart: list[str] = []
        self.closed = threading.Event()
        self._others = others

    @override
    def message(self, kind: str) -> Any:
        return Fields(kind)

    @override
    def latched(self, kind: str, topic: str) -> Take:
        return self.sent.setdefault(topic, []).append

    @override
    def serve(self, name: str, answer: Callable[[], Answer], apart: bool = False) -> None:
        self.services[name] = answer
        if apart:
            self.apart.append(name)

    @override
    def servers(self, name: str) -> int:
        return self._others

    @override
    def now(self) -> float:
        return 12.5

    @override
    def spin(self, seconds: float) -> None:
        time.sleep(min(seconds, 0.002))

    @override
    def close(self) -> None:
        self.closed.set()
