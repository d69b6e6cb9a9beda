"""The only door to rclpy: topics in and out, and what is on the air."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any, Protocol

from typing_extensions import override

from .goals import Accepts, GoalSender, TakesGoal
from .ros_errors import NoRos
from .ros_goals import RosGoalSender, action_servers, actions_of, node_of, serve_action
from .transports import RANGE, environment, shares_memory, transport_variables

Take = Callable[[Any], None]
"""Function that receives a message."""
EMPTY_PASSES = 3
"""Passes without a message after which all have arrived: one pass takes one message of each topic."""
MAX_PASSES = 200
KEPT_MESSAGES = 5
KEPT_BY_KIND = {"tf2_msgs/TFMessage": 100, "sensor_msgs/JointState": 100}
"""Messages kept between two calls of `receive` for types that several nodes publish on one topic: a fast
node must not push out the messages of a slow one. The listener of tf2 keeps 100 as well."""
SPUN_PERIODS = 10
"""Periods between two spins of a node without actions; a spin answers requests for parameters, but gives the
processor away, and a busy machine returns it late."""
SERVICE_TIMEOUT_S = 1.0


class Link(Protocol):
    """Interface of a ROS node's connection to topics and actions, on a ROS network or within this process."""

    place: str = ""
    """Where other nodes are found, for messages, such as `ROS domain 0`; "" within this process."""

    def subscribe(self, kind: str, topic: str, take: Take, latched: bool = False) -> None:
        """Subscribe to a topic with messages of type `kind`, and call `take` with each message.

        `latched` is True to receive also the last message from before, if the publisher keeps it.
        """

    def publisher(self, kind: str, topic: str) -> Take:
        """Return a function that publishes messages of a type such as `sensor_msgs/LaserScan` to a topic."""

    def latched(self, kind: str, topic: str) -> Take:
        """Return a function that publishes messages on a topic; a later subscriber also receives the last
        message.
        """

    def message(self, kind: str) -> Any:
        """Return a new, empty message of a type such as `sensor_msgs/LaserScan`."""

    def receive(self) -> None:
        """Pass all messages that have arrived to the subscribed functions, without waiting for more."""

    def publishers(self, topic: str) -> list[str]:
        """Return the names of all nodes that publish a topic, including this one, each with its message
        type.
        """

    def subscribers(self, topic: str) -> int:
        """Return the number of nodes that subscribe to a topic."""

    def listeners(self, topic: str) -> list[str]:
        """Return the nodes that subscribe to a topic, as texts with the node's name and the message type."""

    def mismatches(self, topic: str, is_command: bool) -> list[str]:
        """Return a text for each node whose quality of service on a topic does not match that of this node.

        Nodes with different qualities of service may exchange no messages. `is_command` is True if this node
        publishes the topic, False if it subscribes.
        """

    def topics_of(self, kind: str) -> list[str]:
        """Return the names of all topics whose messages are of the type `kind`."""

    def joints_of(self, controller: str) -> list[str]:
        """Return the names of the joints that a controller moves, by its node's parameter `joints`; empty if
        unknown.
        """

    def goal_sender(self, kind: str, name: str) -> GoalSender:
        """Return a client of an action, to send goals; `kind` is a type such as
        `control_msgs/FollowJointTrajectory`.
        """

    def serve_action(self, kind: str, name: str, accepts: Accepts, take: TakesGoal) -> None:
        """Create the server of an action.

        Args:
            kind: type of the action, such as `control_msgs/FollowJointTrajectory`.
            name: name of the action.
            accepts: function that returns True to accept a goal, False to reject it, None for no answer.
            take: function that is called with each accepted goal.
        """

    def action_servers(self, name: str) -> list[str]:
        """Return the nodes that serve an action, as texts with the node's name and the action's type."""

    def actions_of(self, kind: str) -> list[str]:
        """Return the names of all actions of a type that have a server."""

    def now(self) -> float:
        """Return the present ROS time in [s], which is used for the stamps of messages."""

    def clock(self) -> float:
        """Return a monotonic time in [s], with which the ages of messages are measured."""

    def close(self) -> None:
        """Close the node's connection to ROS; a second call does nothing."""


class RosLink(Link):
    """Connection to ROS by a node of rclpy, in its own rclpy context; the control loop executes the
    callbacks.

    Subscriptions receive messages of reliable and of best-effort publishers. They request no deadlines and no
    liveliness, because with these they would receive nothing from drivers with default settings.
    """

    def __init__(self, name: str, namespace: str = "", domain: int | None = None) -> None:
        """Start a node.

        Args:
            name: name of the node.
            namespace: namespace of the node's topics.
            domain: ROS domain; None: by the environment.

        Raises:
            NoRos: rclpy, or the middleware that it loads, is not installed.
        """
        try:
            rclpy = import_module("rclpy")
            executors = import_module("rclpy.executors")
            self._qos = import_module("rclpy.qos")
        except ImportError as missing:
            raise NoRos(missing) from None
        variables = transport_variables(rclpy.get_rmw_implementation_identifier())
        with environment(variables):
            self._context, self._node = _new_node(rclpy, name, namespace, domain)
        if RANGE in variables and shares_memory():  # another node of this process was there first
            self._node.destroy_node()
            self._context.try_shutdown()
            self._context, self._node = _new_node(rclpy, name, namespace, domain)
        self.place = f"ROS domain {self._context.get_domain_id()}"
        self._executor = self._new_executor(executors)
        self._executor.add_node(self._node)
        self._heard: list[tuple[Any, Take, int]] = []
        self._came, self._closed, self._has_actions, self._unspun = 0, False, False, 0

    def _new_executor(self, executors: Any) -> Any:
        """Return an executor of the module `rclpy.executors`."""
        return executors.SingleThreadedExecutor(context=self._context)

    @override
    def subscribe(self, kind: str, topic: str, take: Take, latched: bool = False) -> None:
        def came(message: Any) -> None:
            self._note()
            take(message)

        profile = self._profile(is_command=False)
        profile.depth = kept_messages(kind)
        if latched:
            profile.reliability = self._qos.ReliabilityPolicy.RELIABLE
            profile.durability = self._qos.DurabilityPolicy.TRANSIENT_LOCAL
        subscription = self._node.create_subscription(message_class(kind), topic, came, profile)
        self._heard.append((subscription, take, profile.depth))

    @override
    def publisher(self, kind: str, topic: str) -> Take:
        made = self._node.create_publisher(message_class(kind), topic, self._profile(is_command=True))
        publish: Take = made.publish
        return publish

    @override
    def latched(self, kind: str, topic: str) -> Take:
        profile = self._profile(is_command=True)
        profile.durability = self._qos.DurabilityPolicy.TRANSIENT_LOCAL
        publish: Take = self._node.create_publisher(message_class(kind), topic, profile).publish
        return publish

    @override
    def message(self, kind: str) -> Any:
        return message_class(kind)()

    @override
    def receive(self) -> None:
        for subscription, take, depth in self._heard:
            _take_all(subscription, take, depth)
        self._unspun += 1
        if self._has_actions or self._unspun >= SPUN_PERIODS:
            self._unspun = 0
            self._spin()

    def _spin(self) -> None:
        """Execute callbacks that need an executor, such as those of actions and of the node's parameters."""
        empty = 0
        for _ in range(MAX_PASSES):
            before = self._came
            self._executor.spin_once(timeout_sec=0.0)
            empty = 0 if self._came > before else empty + 1
            if empty >= EMPTY_PASSES:
                return

    @override
    def publishers(self, topic: str) -> list[str]:
        full = self._node.resolve_topic_name(topic)
        return list(map(_node_and_type, self._node.get_publishers_info_by_topic(full)))

    @override
    def subscribers(self, topic: str) -> int:
        return int(self._node.count_subscribers(self._node.resolve_topic_name(topic)))

    @override
    def listeners(self, topic: str) -> list[str]:
        full = self._node.resolve_topic_name(topic)
        return list(map(_node_and_type, self._node.get_subscriptions_info_by_topic(full)))

    @override
    def mismatches(self, topic: str, is_command: bool) -> list[str]:
        full, ours = self._node.resolve_topic_name(topic), self._profile(is_command)
        # The graph reports "none" as infinite. Without this it would count as a difference.
        ours.deadline = ours.liveliness_lease_duration = import_module("rclpy.duration").Infinite
        ours.liveliness = self._qos.LivelinessPolicy.AUTOMATIC
        look = self._node.get_subscriptions_info_by_topic if is_command else None
        found = []
        for end in (look or self._node.get_publishers_info_by_topic)(full):
            pair = (ours, end.qos_profile) if is_command else (end.qos_profile, ours)
            verdict, why = self._qos.qos_check_compatible(*pair)
            if verdict == self._qos.QoSCompatibility.ERROR:
                found.append(f"{_node_and_type(end)}: {why.strip()}")
        return found

    def _profile(self, is_command: bool) -> Any:
        """Return the quality of service of commands, or of readings."""
        qos = self._qos
        if is_command:
            return qos.QoSProfile(depth=1, reliability=qos.ReliabilityPolicy.RELIABLE)
        return qos.QoSProfile(
            depth=KEPT_MESSAGES,
            history=qos.HistoryPolicy.KEEP_LAST,
            reliability=qos.ReliabilityPolicy.BEST_EFFORT,
            durability=qos.DurabilityPolicy.VOLATILE,
        )

    @override
    def topics_of(self, kind: str) -> list[str]:
        wanted = kind.replace("/", "/msg/")
        return sorted(name for name, kinds in self._node.get_topic_names_and_types() if wanted in kinds)

    @override
    def joints_of(self, controller: str) -> list[str]:
        kinds = import_module("rcl_interfaces.srv").GetParameters
        client = self._node.create_client(kinds, f"{controller}/get_parameters")
        try:
            if not client.wait_for_service(SERVICE_TIMEOUT_S):
                return []
            answer = client.call_async(kinds.Request(names=["joints"]))
            self._executor.spin_until_future_complete(answer, SERVICE_TIMEOUT_S)
            values = answer.result().values if answer.done() else []
            return [str(name) for value in values for name in value.string_array_value]
        finally:
            self._node.destroy_client(client)

    @override
    def goal_sender(self, kind: str, name: str) -> GoalSender:
        self._has_actions = True
        return RosGoalSender(self._node, kind, name, self._note)

    @override
    def serve_action(self, kind: str, name: str, accepts: Accepts, take: TakesGoal) -> None:
        self._has_actions = True
        serve_action(self._node, kind, name, accepts, take, self._note)

    @override
    def action_servers(self, name: str) -> list[str]:
        return action_servers(self._node, name)

    @override
    def actions_of(self, kind: str) -> list[str]:
        return actions_of(self._node, kind)

    def _note(self) -> None:
        """Note that a message has arrived, so that `receive` returns."""
        self._came += 1

    @override
    def now(self) -> float:
        return float(self._node.get_clock().now().nanoseconds) / 1e9

    @override
    def clock(self) -> float:
        return time.monotonic()

    @override
    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        self._executor.shutdown(timeout_sec=0.5)
        self._node.destroy_node()
        self._context.try_shutdown()


def _new_node(rclpy: Any, name: str, namespace: str, domain: int | None) -> tuple[Any, Any]:
    """Start a node of the module `rclpy`; return its context, of its own, and the node."""
    context = import_module("rclpy.context").Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    return context, rclpy.create_node(name, namespace=namespace or None, context=context)


def kept_messages(kind: str) -> int:
    """Return the number of messages of a type that are kept between two calls of `receive`."""
    return KEPT_BY_KIND.get(kind, KEPT_MESSAGES)


def _take_all(subscription: Any, take: Take, depth: int) -> None:
    """Take the messages that have arrived, at most `depth`, without waiting for any."""
    with subscription.handle:
        for _ in range(depth):
            taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
            if taken is None:
                return
            take(taken[0])


def message_class(kind: str) -> Any:
    """Return the class of a message such as `sensor_msgs/LaserScan`; raise `NoRos` if not installed."""
    package, _, name = kind.partition("/")
    try:
        return getattr(import_module(f"{package}.msg"), name)
    except ImportError as missing:
        raise NoRos(missing) from None


def _node_and_type(end: Any) -> str:
    """Return the node of a publisher or subscription, with the type of its messages."""
    return f"{node_of(end)} ({end.topic_type.replace('/msg', '')})"


def node_name(what: str) -> str:
    """Return a name for a ROS node that is unique on this machine and contains `what`, its purpose."""
    return f"handcart_{what}_{os.getpid()}_{time.monotonic_ns() % 100_000}"
