"""Goals of actions, as this program sends them and as a simulated driver receives them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, Protocol
from uuid import uuid4


class GoalStage(Enum):
    """State of an action's goal, from sending it to its end."""

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


class RivalWatch:
    """Detector of goals of other nodes by the states of all goals of an action's server.

    Identifiers of this program's goals begin alike, so that its oldest ones are recognized too: servers list
    ended goals for 10 s to 15 minutes, at 20 goals a second.
    """

    def __init__(self) -> None:
        """Begin without a goal."""
        self._prefix, self._count = uuid4().bytes[:8], 0
        self._known: set[bytes] = set()
        self._is_rival_active = self._has_intruded = False

    def new_id(self) -> bytes:
        """Return the identifier, 16 bytes, of a further goal of this program."""
        self._count += 1
        return self._prefix + self._count.to_bytes(8, "big")

    def take(self, states: Mapping[bytes, int]) -> None:
        """Take the states of all goals of a server, as numbers of `action_msgs` by identifier."""
        foreign = {name: state for name, state in states.items() if not name.startswith(self._prefix)}
        self._is_rival_active = any(state in ACTIVE_NUMBERS for state in foreign.values())
        # A goal that a newer one of ours replaced is over when its state arrives. It was executed anyway.
        self._has_intruded |= self._count > 0 and not foreign.keys() <= self._known
        self._known |= foreign.keys()

    @property
    def has_found(self) -> bool:
        """True if the server executes a goal of another node, or did since this program's first goal."""
        return self._is_rival_active or self._has_intruded


class SentGoal(Protocol):
    """A goal that was sent, with the answers that have arrived.

    Attributes:
        state: stage that the goal has reached.
        result: result of the goal; None before its end.
    """

    state: GoalStage
    result: Any

    def cancel(self) -> None:
        """Ask the server to cancel the goal; if the server has not accepted the goal yet, ask when it accepts
        it.
        """


class GoalSender(Protocol):
    """Interface of a client that sends goals to a ROS action."""

    def is_ready(self) -> bool:
        """Return True if a server of the action is connected."""

    def others_goal(self) -> bool:
        """Return True if the server executes a goal of another node."""

    def servers(self) -> frozenset[bytes]:
        """Return an identifier of each server of the action, which another process never has; empty where
        servers have none.
        """
        return frozenset()

    def new_goal(self) -> Any:
        """Return an empty goal message of the action's type."""

    def send(self, goal: Any) -> SentGoal:
        """Send a goal without waiting for an answer."""


class ServedGoal(Protocol):
    """Interface by which the server of a ROS action reads a goal that it has accepted, and reports the
    result.
    """

    @property
    def request(self) -> Any:
        """Goal message that the client has sent."""

    @property
    def is_cancel_asked(self) -> bool:
        """True if the client has requested to cancel the goal."""

    def new_result(self) -> Any:
        """Return an empty result message of the ROS action's type, to be filled in and sent."""

    def end(self, state: GoalStage, result: Any) -> None:
        """Set the final state of the goal, and send its result.

        Args:
            state: final state.
            result: message made by `new_result`.
        """


Accepts = Callable[[Any], bool | None]
"""Function that returns whether a goal is accepted; None to leave it without an answer."""
TakesGoal = Callable[[ServedGoal], None]
