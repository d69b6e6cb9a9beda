"""One goal of an action server, polled once a period; nothing here waits for it."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from handcart.backends.ros2.wire.ros_link import RosLink

from .stacks import GoalState, NoStack

SERVER_TIMEOUT_S = 5.0
GOAL_STATES = {4: GoalState.SUCCEEDED, 5: GoalState.CANCELED, 6: GoalState.ABORTED}
"""States of a goal by the numbers of `action_msgs/GoalStatus`."""


class ActionGoal:
    """Client of an action of another node, by a node of its own."""

    def __init__(self, link: RosLink, package: str, action: str, name: str) -> None:
        """Connect to a server.

        Args:
            link: node, of which this is part.
            package: of the action's type.
            action: name of the type.
            name: name of the server.

        Raises:
            NoStack: the type is not installed, or no server is there.
        """
        try:
            self.type = getattr(import_module(f"{package}.action"), action)
            clients = import_module("rclpy.action")
        except ImportError as missing:
            raise NoStack(f"{missing.name} is not installed; needed: {package}, as on the robot") from None
        self._client = clients.ActionClient(link._node, self.type, name)
        if not self._client.wait_for_server(timeout_sec=SERVER_TIMEOUT_S):
            raise NoStack(f"no server of {name} ({package}/{action}) within {SERVER_TIMEOUT_S:g} s")
        self._state, self._handle, self._canceled = GoalState.SENT, None, False
        self.result: Any = None

    def send(self, goal: Any) -> None:
        """Send a goal."""
        self._state, self._handle = GoalState.SENT, None
        self._client.send_goal_async(goal).add_done_callback(self._answered)

    def state(self) -> GoalState:
        """Return its state, by what has arrived."""
        return self._state

    def cancel(self) -> None:
        """Cancel it; a second call does nothing."""
        self._canceled = True
        if self._handle is not None and self._state is GoalState.RUNNING:
            self._handle.cancel_goal_async()

    def _answered(self, answer: Any) -> None:
        self._handle = answer.result()
        if not self._handle.accepted:
            self._state = GoalState.REJECTED
            return
        self._state = GoalState.RUNNING
        self._handle.get_result_async().add_done_callback(self._ended)
        if self._canceled:  # before it was accepted
            self._handle.cancel_goal_async()

    def _ended(self, answer: Any) -> None:
        got = answer.result()
        self.result, self._state = got.result, GOAL_STATES.get(got.status, GoalState.ABORTED)
