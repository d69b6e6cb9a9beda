"""Goals of actions, as this program sends them and as a simulated driver receives them."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any, Protocol


class GoalStage(Enum):
    """State of a goal."""

    SENT = "sent"
    RUNNING = "running"
    REJECTED = "rejected"
    SUCCEEDED = "succeeded"
    CANCELED = "canceled"
    ABORTED = "aborted"


ENDS_BY_NUMBER = {4: GoalStage.SUCCEEDED, 5: GoalStage.CANCELED, 6: GoalStage.ABORTED}
"""Ends of a goal by the numbers of `action_msgs`."""
ACTIVE_NUMBERS = (1, 2, 3)
"""Numbers of a goal that is accepted, executed, or about to be cancelled."""


class SentGoal(Protocol):
    """A goal that was sent, with the answers that have arrived.

    Attributes:
        state: stage that it has reached.
        result: result of the goal; None before its end.
    """

    state: GoalStage
    result: Any

    def cancel(self) -> None:
        """Ask the server to cancel the goal; one that is not accepted yet is cancelled as soon as it is."""


class GoalSender(Protocol):
    """End of an action from which goals are sent."""

    def is_ready(self) -> bool:
        """Return whether a server is connected."""

    def others_goal(self) -> bool:
        """Return whether a goal of another node is being executed."""

    def new_goal(self) -> Any:
        """Return an empty goal."""

    def send(self, goal: Any) -> SentGoal:
        """Send a goal; never waits."""


class ServedGoal(Protocol):
    """A goal that was accepted, at the end of an action that serves it."""

    @property
    def request(self) -> Any:
        """Return the message of the goal."""

    @property
    def is_cancel_asked(self) -> bool:
        """Return whether its sender wants it to end."""

    def new_result(self) -> Any:
        """Return an empty result."""

    def end(self, state: GoalStage, result: Any) -> None:
        """Set the final state of the goal, and send its result.

        Args:
            state: final state.
            result: message made by `new_result`.
        """


Accepts = Callable[[Any], bool | None]
"""Function that returns whether a goal is accepted; None to leave it without an answer."""
TakesGoal = Callable[[ServedGoal], None]
