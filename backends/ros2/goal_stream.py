"""Goals of one controller's action, one after the other, and what becomes of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .wire.goals import GoalSender, GoalStage, SentGoal

ERROR_NAMES = {
    -1: "INVALID_GOAL",
    -2: "INVALID_JOINTS",
    -3: "OLD_HEADER_TIMESTAMP",
    -4: "PATH_TOLERANCE_VIOLATED",
    -5: "GOAL_TOLERANCE_VIOLATED",
}
"""Names of `error_code` in a result of `FollowJointTrajectory`."""
PREEMPTED = ("", "INVALID_GOAL")
"""Errors with which a controller ends a goal because a newer one came."""


@dataclass
class _Watched:
    """A sent goal that has not ended."""

    goal: SentGoal
    sent_s: float
    was_replaced: bool = False
    was_cancelled: bool = False


class GoalStream:
    """Sender of goals to the action of a controller, one in each control period; it also monitors the goals.

    Each goal replaces the goal before it. A trajectory goal ends with the period for which it was computed;
    if no further goal follows, for example because this program was killed, the controller holds the goal's
    end. A goal that is rejected, aborted, cancelled by another node, or not answered is a fault; a replaced
    goal that ends early is not.
    """

    def __init__(
        self,
        sender: GoalSender,
        name: str,
        kind: str,
        answer: float,
        clock: Callable[[], float],
        may_miss: bool = False,
    ) -> None:
        """Take the end of the action.

        Args:
            sender: end of the action from which goals are sent.
            name: name of the action.
            kind: type of the action.
            answer: time in [s] in which a goal has to be accepted.
            clock: gives the time in [s].
            may_miss: True for fingers, which miss their goal when they press on something.
        """
        self.sender, self.name, self.kind = sender, name, kind
        self._answer, self._clock, self._may_miss = answer, clock, may_miss
        self._watched: list[_Watched] = []
        self._servers: frozenset[bytes] | None = None
        self.trouble = ""
        """Fault of a goal in words; "" without a fault."""

    def begin(self) -> None:
        """Note the servers of the action before the first goal."""
        self._servers = self.sender.servers()

    def send(self, goal: Any) -> None:
        """Send a goal to the robot's controller; it replaces the goal that was sent before."""
        for watched in self._watched:
            watched.was_replaced = True
        self._watched.append(_Watched(self.sender.send(goal), self._clock()))

    def cancel(self) -> None:
        """Cancel the goal that was sent last, if it has not ended; earlier goals were replaced by it."""
        for watched in self._watched:
            if not watched.was_replaced:
                watched.goal.cancel()
            watched.was_cancelled = True

    def advance(self) -> None:
        """Check the state of each goal sent to the robot's controller; store the first fault as text in
        `trouble`.
        """
        for watched in self._watched:
            self.trouble = self.trouble or self._wrong(watched)
        self.trouble = self.trouble or self.rival
        self._watched = [
            watched for watched in self._watched if watched.goal.state in (GoalStage.SENT, GoalStage.RUNNING)
        ]

    @property
    def rival(self) -> str:
        """Description of another program that commands the controller; "" without one."""
        if not self.sender.others_goal():
            return ""
        return f"{self.name}: a goal of another node is executed; allowed: goals of this program alone"

    @property
    def restart(self) -> str:
        """Description of a server that appeared since `begin`; "" without one.

        Goals of a server that has died never end for their sender.
        """
        if self._servers is None or not self.sender.servers() - self._servers:
            return ""
        return f"{self.name}: another server of the action has appeared; was its controller started again?"

    def forget(self) -> None:
        """Stop monitoring the goals that were sent, without cancelling them, and discard the fault that was
        found in them, if any.
        """
        self._watched, self.trouble = [], ""

    def _wrong(self, each: _Watched) -> str:
        """Return what is wrong with a goal; "" if nothing is."""
        goal, waited = each.goal, self._clock() - each.sent_s
        expected = each.was_replaced or each.was_cancelled
        match goal.state:
            case GoalStage.SENT if waited > self._answer:
                return f"{self.name}: no answer to a goal for {waited:.2g} s; allowed: {self._answer:g} s"
            case GoalStage.REJECTED:
                return (
                    f"{self.name}: the controller rejected a goal; is it active, and are the joints its own?"
                )
            case GoalStage.CANCELED if not expected:
                return f"{self.name}: somebody else cancelled a goal{_why(goal.result)}"
            case GoalStage.ABORTED if not self._may_abort(goal.result, expected):
                return f"{self.name}: the controller aborted a goal{_why(goal.result)}"
        return ""

    def _may_abort(self, result: Any, expected: bool) -> bool:
        """Return whether an abort is expected: fingers press on something, or a newer goal came."""
        error = _error_name(result)
        if self._may_miss and (getattr(result, "stalled", False) or error == ERROR_NAMES[-5]):
            return True
        return expected and error in PREEMPTED


def _why(result: Any) -> str:
    """Return the error of a result, as words after a colon."""
    words = [item for item in (_error_name(result), getattr(result, "error_string", "")) if item]
    return f": {', '.join(words)}" if words else ""


def _error_name(result: Any) -> str:
    code = int(getattr(result, "error_code", 0))
    return ERROR_NAMES.get(code, f"error {code}") if code else ""
