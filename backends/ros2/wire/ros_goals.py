"""Actions through rclpy."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from typing_extensions import override

from .goals import (
    ENDS_BY_NUMBER,
    Accepts,
    GoalSender,
    GoalStage,
    RivalWatch,
    SentGoal,
    ServedGoal,
    TakesGoal,
)
from .ros_errors import NoRos

STATE_TOPIC = "/_action/status"
FEEDBACK_TOPIC, FEEDBACK_TYPE = "/_action/feedback", "_FeedbackMessage"
UNKNOWN_NODE = "_NODE_NAME_UNKNOWN_"
Came = Callable[[], None]
"""Function that notes that something has arrived."""


class RosGoalSender(GoalSender):
    """Client of a ROS action, which sends goals; answers are received while rclpy spins the node."""

    def __init__(self, node: Any, kind: str, name: str, came: Came) -> None:
        """Connect to the servers of an action.

        Args:
            node: node of rclpy.
            kind: type of the action, such as `control_msgs/FollowJointTrajectory`.
            name: name of the action.
            came: notes that an answer or the states of goals have arrived.

        Raises:
            NoRos: the package of the action is not installed.
        """
        self._type, self._came, self._node = action_class(kind), came, node
        self._states = f"{node.resolve_service_name(name)}{STATE_TOPIC}"
        self._client = import_module("rclpy.action").ActionClient(node, self._type, name)
        self._new_id = import_module("unique_identifier_msgs.msg").UUID
        self._rivals = RivalWatch()
        kind_of_state = import_module("action_msgs.msg").GoalStatusArray
        profile = import_module("rclpy.qos").qos_profile_action_status_default
        node.create_subscription(kind_of_state, self._states, self._heard, profile)

    @override
    def is_ready(self) -> bool:
        return bool(self._client.server_is_ready())

    @override
    def others_goal(self) -> bool:
        return self._rivals.has_found

    @override
    def servers(self) -> frozenset[bytes]:
        ends = self._node.get_publishers_info_by_topic(self._states)
        return frozenset(bytes(end.endpoint_gid) for end in ends)

    def _heard(self, message: Any) -> None:
        """Take the states of all goals of the server, of other clients as well."""
        self._came()
        states = {bytes(item.goal_info.goal_id.uuid): int(item.status) for item in message.status_list}
        self._rivals.take(states)

    @override
    def new_goal(self) -> Any:
        return self._type.Goal()

    @override
    def send(self, goal: Any) -> SentGoal:
        sent, name = _RosGoal(self._came), self._rivals.new_id()
        goal_id = self._new_id(uuid=np.frombuffer(name, np.uint8))
        self._client.send_goal_async(goal, goal_uuid=goal_id).add_done_callback(sent.answered)
        return sent


class _RosGoal(SentGoal):
    """A goal that was sent through rclpy."""

    def __init__(self, came: Came) -> None:
        """Begin without an answer."""
        self._came, self._handle, self._cancel = came, None, False
        self.state, self.result = GoalStage.SENT, None

    @override
    def cancel(self) -> None:
        self._cancel = True
        if self._handle is not None and self.state is GoalStage.RUNNING:
            self._handle.cancel_goal_async()

    def answered(self, answer: Any) -> None:
        """Take the server's answer."""
        self._came()
        handle = self._handle = answer.result()
        if not handle.accepted:
            self.state = GoalStage.REJECTED
            return
        self.state = GoalStage.RUNNING
        handle.get_result_async().add_done_callback(self._ended)
        if self._cancel:
            handle.cancel_goal_async()

    def _ended(self, answer: Any) -> None:
        self._came()
        got = answer.result()
        self.result = got.result
        self.state = ENDS_BY_NUMBER.get(got.status, GoalStage.ABORTED)


class _RosServedGoal(ServedGoal):
    """A goal that a server of rclpy has accepted."""

    def __init__(self, handle: Any, kind: Any) -> None:
        """Take its handle and the type of the action."""
        self._handle, self._type = handle, kind

    @property
    @override
    def request(self) -> Any:
        return self._handle.request

    @property
    @override
    def is_cancel_asked(self) -> bool:
        return bool(self._handle.is_cancel_requested)

    @override
    def new_result(self) -> Any:
        return self._type.Result()

    @override
    def end(self, state: GoalStage, result: Any) -> None:
        def finish(handle: Any) -> Any:
            if state is GoalStage.SUCCEEDED:
                handle.succeed()
            elif state is GoalStage.CANCELED and handle.is_cancel_requested:
                handle.canceled()
            else:  # only what was asked to end can be cancelled
                handle.abort()
            return result

        self._handle.execute(finish)


def serve_action(node: Any, kind: str, name: str, accepts: Accepts, take: TakesGoal, came: Came) -> None:
    """Create the server of an action in a node.

    Args:
        node: node of rclpy.
        kind: type of the action, such as `control_msgs/FollowJointTrajectory`.
        name: name of the action.
        accepts: function that returns True to accept a goal, False to reject it, None for no answer.
        take: function that is called with each accepted goal.
        came: function that is called when a goal, or a request to cancel a goal, arrives.

    Raises:
        NoRos: the package of the action is not installed.
    """
    made = action_class(kind)
    actions = import_module("rclpy.action")
    never = import_module("rclpy.task").Future
    group = import_module("rclpy.callback_groups").ReentrantCallbackGroup()  # for a goal without an answer

    async def answer(goal: Any) -> Any:
        came()
        verdict = accepts(goal)
        if verdict is None:
            await never()
        return actions.GoalResponse.ACCEPT if verdict else actions.GoalResponse.REJECT

    def asked_to_end(_: Any) -> Any:
        came()
        return actions.CancelResponse.ACCEPT

    actions.ActionServer(
        node,
        made,
        name,
        execute_callback=lambda handle: None,  # goals are executed by `end`
        goal_callback=answer,
        handle_accepted_callback=lambda handle: take(_RosServedGoal(handle, made)),
        cancel_callback=asked_to_end,
        callback_group=group,
    )


def action_servers(node: Any, name: str) -> list[str]:
    """Return the nodes that serve an action, as texts with the node's name and the action's type."""
    full = node.resolve_service_name(name)
    ends = node.get_publishers_info_by_topic(f"{full}{FEEDBACK_TOPIC}")
    return [
        f"{node_of(end)} ({end.topic_type.removesuffix(FEEDBACK_TYPE).replace('/action', '')})"
        for end in ends
    ]


def actions_of(node: Any, kind: str) -> list[str]:
    """Return the names of all actions of a type that have a server; the package of the type is not needed.

    A server is recognized by the action's feedback topic, which it publishes. A client only subscribes to
    this topic. Node names are not used, because they are discovered later than topics.
    """
    wanted = f"{kind.replace('/', '/action/')}{FEEDBACK_TYPE}"
    topics = (topic for topic, kinds in node.get_topic_names_and_types() if wanted in kinds)
    return sorted(topic.removesuffix(FEEDBACK_TOPIC) for topic in topics if node.count_publishers(topic))


def node_of(end: Any) -> str:
    """Return the node name of a publisher or subscription, or a placeholder text if ROS has not discovered
    the name yet.
    """
    if end.node_name == UNKNOWN_NODE:
        return "a node without a name yet"
    return f"{end.node_namespace.rstrip('/')}/{end.node_name}"


def action_class(kind: str) -> Any:
    """Return the class of an action such as `control_msgs/GripperCommand`; raise `NoRos` if not installed."""
    package, _, name = kind.partition("/")
    try:
        return getattr(import_module(f"{package}.action"), name)
    except ImportError as missing:
        raise NoRos(missing) from None
