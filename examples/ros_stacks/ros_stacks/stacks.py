"""Interfaces to Nav2 and MoveIt that the primitives use, so that tests need neither."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple, Protocol

from handcart.files.errors import HandcartError


class GoalState(Enum):
    """Present state of a goal of an action server."""

    SENT = "sent, not accepted yet"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    REJECTED = "rejected"
    ABORTED = "aborted"
    CANCELED = "canceled"


ENDED_STATES = (GoalState.SUCCEEDED, GoalState.REJECTED, GoalState.ABORTED, GoalState.CANCELED)


class NoStack(HandcartError):
    """The stack's messages are not installed, or no server is on the air."""


class Speeds(NamedTuple):
    """Speeds that Nav2's controller asks for."""

    forward_m_s: float
    turn_rad_s: float


class Navigator(Protocol):
    """Nav2: one goal at a time. No method waits."""

    def go_to(self, x: float, y: float, heading: float) -> None:
        """Send a pose on the map, in [m] and [rad], as the goal."""

    def state(self) -> GoalState:
        """Return the state of the goal, by the messages that have arrived."""

    def speeds(self) -> Speeds | None:
        """Return the newest speeds since the last call; None if none have come."""

    def cancel(self) -> None:
        """Cancel the goal; a second call does nothing."""

    def close(self) -> None:
        """Cancel, and leave; a second call does nothing."""


class Waypoints(NamedTuple):
    """A planned path of the arm."""

    names: Sequence[str]
    """(n) joints."""
    positions: Sequence[Sequence[float]]
    """(m, n) in [rad] or [m]."""


class ArmPlanner(Protocol):
    """MoveIt: one plan at a time. No method waits."""

    def plan(self, group: str, names: Sequence[str], goal: Sequence[float]) -> None:
        """Ask for a path of a group's joints to a goal in [rad] or [m]; nothing moves."""

    def state(self) -> GoalState:
        """Return the state of the request."""

    def path(self) -> Waypoints:
        """Return the path, once it has succeeded."""

    def why(self) -> str:
        """Return the reason for a missing path."""

    def close(self) -> None:
        """Cancel, and leave; a second call does nothing."""
