"""Events that a coordinator publishes to its observers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from handcart.networks.graph.network import Action
from handcart.networks.graph.planner import NoWay, Plan
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.outcome import Outcome

from .run_end import RunEnd


@dataclass(frozen=True)
class Planned:
    """Event of a run that has planned how to go on, with the route, or with the reason why none was found."""

    time: float
    """The robot's time, in [s], as in all events."""
    situation: str
    plan: Plan | NoWay


@dataclass(frozen=True)
class Started:
    """Event: an action starts, with its number in the run, its primitive and the number of earlier Fails."""

    time: float
    number: int
    """Number of the action in the run, from 1."""
    action: Action
    primitive: ActionPrimitive
    fails: int
    """Number of earlier Fails of this action."""


@dataclass(frozen=True)
class Restoring:
    """Event that the running action begins to restore the state found at its start, with the reason."""

    time: float
    action: Action
    reason: str


@dataclass(frozen=True)
class Ended:
    """Event of an action that has ended, with its number, its outcome, and the facts that were learned.

    It is sent after the outcome is in the journal.
    """

    time: float
    number: int
    action: Action
    primitive: ActionPrimitive
    """The primitive, with its evidence."""
    outcome: Outcome
    changes: Mapping[str, Any]
    """Facts that were learned or forgotten."""


@dataclass(frozen=True)
class LeftOut:
    """Event that an action is not started, or that a repeated part of a task is skipped for one of its
    elements.
    """

    time: float
    action: Action
    reason: str


@dataclass(frozen=True)
class AimChanged:
    """Event that a round of a repeated task or an interrupt begins, or that the goal is abandoned, described
    in words.
    """

    time: float
    words: str


@dataclass(frozen=True)
class RunEnded:
    """Event: the run has ended, with its outcome and the reason."""

    time: float
    end: RunEnd


Event = Planned | Started | Restoring | Ended | LeftOut | AimChanged | RunEnded
