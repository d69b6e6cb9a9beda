"""A node that publishes a state that stays readable, and answers services."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple, Protocol

from typing_extensions import override

from .ros_errors import NoRos
from .ros_link import RosLink, Take

DIAGNOSTICS_TOPIC = "/diagnostics"
SERVICE_THREAD_COUNT = 4
"""Threads that answer services."""


class Answer(NamedTuple):
    """Answer to a call of a `std_srvs/Trigger` service, with success and a message."""

    success: bool
    message: str


class ServingLink(Protocol):
    """Interface of a connection to ROS 2 for a program that publishes its state and offers services."""

    def message(self, kind: str) -> Any:
        """Return a new, empty message of a type such as `std_msgs/String`."""

    def latched(self, kind: str, topic: str) -> Take:
        """Return a function that publishes messages of type `kind` to a topic.

        Later subscribers receive the last message as well.
        """

    def serve(self, name: str, answer: Callable[[], Answer], apart: bool = False) -> None:
        """Offer a service of type `std_srvs/Trigger`.

        Args:
            name: name of the service.
            answer: function that computes the answer to a call.
            apart: True to answer calls in parallel to other services; False: one call after the other.
        """

    def servers(self, name: str) -> int:
        """Return the number of nodes that offer a service."""

    def now(self) -> float:
        """Return the time of ROS in [s]."""

    def spin(self, seconds: float) -> None:
        """Answer the calls that arrive within a time in [s]."""

    def close(self) -> None:
        """Close the connection to ROS; a second call does nothing."""


class RosServingLink(RosLink, ServingLink):
    """Connection to ROS 2 by a node of rclpy, which answers service calls in separate threads."""

    @override
    def _new_executor(self, executors: Any) -> Any:
        # By default it has a thread for each core. With one core a stop would wait for another answer.
        return executors.MultiThreadedExecutor(SERVICE_THREAD_COUNT, context=self._context)

    @override
    def serve(self, name: str, answer: Callable[[], Answer], apart: bool = False) -> None:
        def served(_: Any, response: Any) -> Any:
            try:
                response.success, response.message = answer()
            except Exception as error:  # the caller needs an answer, and the node keeps running
                response.success, response.message = False, f"{type(error).__name__}: {error}"
            return response

        try:
            groups = import_module("rclpy.callback_groups")
            trigger = import_module("std_srvs.srv").Trigger
        except ImportError as missing:
            raise NoRos(missing) from None
        group = groups.MutuallyExclusiveCallbackGroup() if apart else None
        self._node.create_service(trigger, name, served, callback_group=group)

    @override
    def servers(self, name: str) -> int:
        full = self._node.resolve_service_name(name)
        return sum(
            full in dict(self._node.get_service_names_and_types_by_node(node, namespace))
            for node, namespace in self._node.get_node_names_and_namespaces()
            if (node, namespace) != (self._node.get_name(), self._node.get_namespace())
        )

    @override
    def spin(self, seconds: float) -> None:
        self._executor.spin_once(timeout_sec=seconds)
