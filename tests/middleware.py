"""A node of rclpy, for tests through the middleware; imported only where rclpy is installed."""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

from handcart.backends.ros2.wire.ros_link import RosLink, message_class, node_name

Take = Callable[[Any], object]


def passes_messages(timeout_s: float = 20.0) -> bool:
    """Return whether the middleware passes messages between two nodes of this machine."""
    heard: list[object] = []
    speaker, listener = RosLink("speaker"), RosLink("listener")
    listener.subscribe("geometry_msgs/Twist", "heard", heard.append)
    speak, until = speaker.publisher("geometry_msgs/Twist", "heard"), time.monotonic() + timeout_s
    while not heard and time.monotonic() < until:
        speak(speaker.message("geometry_msgs/Twist"))
        time.sleep(0.05)
        listener.receive()
    speaker.close()
    listener.close()
    return bool(heard)


class Client(RosLink):
    """Node of a person's program: listens, also to the last message before it came, and calls services."""

    def __init__(self) -> None:
        super().__init__(node_name("client"))

    def listen(self, kind: str, topic: str, take: Take) -> None:
        """Call `take` with each message, and with the last one before."""
        qos = self._qos
        profile = qos.QoSProfile(
            depth=5,
            reliability=qos.ReliabilityPolicy.RELIABLE,
            durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
        )
        self._node.create_subscription(message_class(kind), topic, take, profile)

    def wait(self, condition: Callable[[], bool], seconds: float) -> None:
        """Receive until a condition holds; fails after so many seconds."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"not within {seconds:g} s"
            self._executor.spin_once(timeout_sec=0.05)

    def send(self, service: str, seconds: float = 60.0) -> Any:
        """Call a Trigger service, and return its answer to come."""
        trigger = import_module("std_srvs.srv").Trigger
        client = self._node.create_client(trigger, service)
        self.wait(client.service_is_ready, seconds)
        return client.call_async(trigger.Request())

    def call(self, service: str, seconds: float = 60.0) -> Any:
        """Call a Trigger service, and return its answer."""
        answer = self.send(service, seconds)
        self.wait(answer.done, seconds)
        return answer.result()
