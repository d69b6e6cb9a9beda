"""Actions within this process, without rclpy."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from typing_extensions import override

from handcart.backends.ros2.wire.goals import Accepts, GoalSender, GoalStage, SentGoal, ServedGoal, TakesGoal

from .local_messages import new_goal, new_result


class LocalGoal(SentGoal, ServedGoal):
    """A goal of an action within this process, with its state and result, shared by sender and server."""

    def __init__(self, kind: str, request: Any) -> None:
        """Begin without an answer; `kind` is the type of the action."""
        self._kind, self._request = kind, request
        self.state, self.result, self._cancel = GoalStage.SENT, None, False

    @property
    @override
    def request(self) -> Any:
        return self._request

    @property
    @override
    def is_cancel_asked(self) -> bool:
        return self._cancel

    @override
    def cancel(self) -> None:
        self._cancel = True

    @override
    def new_result(self) -> Any:
        return new_result(self._kind)

    @override
    def end(self, state: GoalStage, result: Any) -> None:
        self.state, self.result = state, result


class LocalAction:
    """Server of an action within this process; it answers the waiting goals when its node processes messages
    (`receive`).
    """

    def __init__(self, kind: str, accepts: Accepts, take: TakesGoal) -> None:
        """Serve an action.

        Args:
            kind: type of the action.
            accepts: returns whether a goal is accepted; None leaves the goal without an answer.
            take: receives each goal that is accepted.
        """
        self.kind = kind
        self._accepts, self._take = accepts, take
        self._waiting: deque[LocalGoal] = deque()
        self._taken: list[LocalGoal] = []

    def running(self) -> list[LocalGoal]:
        """Return the goals that are being executed."""
        self._taken = [item for item in self._taken if item.state is GoalStage.RUNNING]
        return self._taken

    def send(self, request: Any) -> LocalGoal:
        """Add a goal to the queue of goals that `answer` accepts or rejects, and return it."""
        goal = LocalGoal(self.kind, request)
        self._waiting.append(goal)
        return goal

    def answer(self) -> None:
        """Accept or reject the queued goals; a goal for which `accepts` returns None gets no answer."""
        while self._waiting:
            goal = self._waiting.popleft()
            verdict = self._accepts(goal.request)
            if verdict:
                goal.end(GoalStage.RUNNING, None)
                self._taken.append(goal)
                self._take(goal)
            elif verdict is not None:
                goal.end(GoalStage.REJECTED, None)


class LocalGoalSender(GoalSender):
    """Client of a ROS action whose server is in this process, without ROS itself."""

    def __init__(self, kind: str, server: Callable[[], LocalAction | None]) -> None:
        """Take the type of the action, and a function that returns the action's server; None without a
        server.
        """
        self._kind, self._server = kind, server
        self._own: list[LocalGoal] = []

    @override
    def is_ready(self) -> bool:
        return self._server() is not None

    @override
    def others_goal(self) -> bool:
        server = self._server()
        return server is not None and any(item not in self._own for item in server.running())

    @override
    def new_goal(self) -> Any:
        return new_goal(self._kind)

    @override
    def send(self, goal: Any) -> SentGoal:
        server = self._server()
        sent = LocalGoal(self._kind, goal) if server is None else server.send(goal)
        running = (GoalStage.SENT, GoalStage.RUNNING)
        self._own = [*(item for item in self._own if item.state in running), sent]
        return sent
