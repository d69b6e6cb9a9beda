"""The cheapest route to the goal, with failed actions made dearer; and a run's position on it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import networkx as nx

from handcart.primitives.contract.outcome import Fail, Outcome, Success

from .network import Action, ActionNetwork

SKIP_WEIGHT = 1e12
"""Weight of leaving an element undone, in [s]: more than all that could still be tried."""


@dataclass(frozen=True)
class Plan:
    """The next action and those after it."""

    actions: tuple[Action, ...]
    cost: float
    """The sum of planning weights, in [s]."""
    excluded: tuple[Action, ...]
    """Excluded actions: those that failed as often as they may."""


@dataclass(frozen=True)
class NoWay:
    """No action that is left leads on to the goal."""

    situation: str
    blocking: tuple[Action, ...]
    """The actions that would lead on, had they not been used up."""
    explanation: str


@dataclass(frozen=True)
class NotStarted:
    """An action that could not be started: refused, or a parameter isn't known. Counts as a Fail."""

    reason: str


@dataclass(frozen=True)
class Elsewhere(NotStarted):
    """An action that was not started because the world was changed: another situation holds."""

    situation: str


class Planner:
    """Dijkstra's search over a network that it does not change: weights hide excluded actions."""

    def __init__(self, network: ActionNetwork) -> None:
        self.network = network
        self._fails = [0] * len(network.actions)
        self._out = [False] * len(network.actions)
        self._weights = [SKIP_WEIGHT if a.binding is None else a.cost_s for a in network.actions]
        self._reasons: dict[int, str] = {}

    def fails(self, action: Action) -> int:
        """Return the number of Fails of an action."""
        return self._fails[action.index]

    def failed(self, action: Action, reason: str, *, permanent: bool = False) -> None:
        """Count a Fail; a permanent one uses up all attempts."""
        index = action.index
        self._fails[index] += 1
        self._reasons[index] = reason
        self._weights[index] = math.ldexp(action.cost_s, self._fails[index])
        self._out[index] = permanent or self._fails[index] >= action.attempts

    def plan(self, situation: str) -> Plan | NoWay:
        """Return the cheapest route from `situation` to the goal."""
        try:
            cost, nodes = nx.single_source_dijkstra(
                self.network.graph, situation, self.network.goal, weight=self._weight
            )
        except nx.NetworkXNoPath:
            return self._no_way(situation)
        pairs = itertools.pairwise(nodes)
        return Plan(tuple(self._best(*pair) for pair in pairs), float(cost), self._excluded())

    def _weight(self, _source: str, _target: str, edges: Mapping[int, Any]) -> float | None:
        # None hides an edge from networkx.
        return min((self._weights[index] for index in edges if not self._out[index]), default=None)

    def _best(self, source: str, target: str) -> Action:
        left = [index for index in self.network.graph[source][target] if not self._out[index]]
        best: int = min(left, key=lambda index: (self._weights[index], index))
        return self.network.actions[best]

    def _excluded(self) -> tuple[Action, ...]:
        return tuple(action for action in self.network.actions if self._out[action.index])

    def _no_way(self, situation: str) -> NoWay:
        graph, goal = self.network.graph, self.network.goal
        reached = self._reached(situation)
        useful = nx.ancestors(graph, goal) | {goal}
        blocking = tuple(
            action
            for action in self._excluded()
            if action.source in reached and action.target in useful - reached
        )
        words = "; ".join(self._why(action) for action in blocking) or f"nothing leads from {situation} there"
        return NoWay(situation, blocking, f"no way left from {situation} to {goal}: {words}")

    def _reached(self, situation: str) -> set[str]:
        usable: Iterable[Action] = (a for a in self.network.actions if not self._out[a.index])
        left: nx.DiGraph[str] = nx.DiGraph([(a.source, a.target) for a in usable])
        left.add_node(situation)
        return {situation, *nx.descendants(left, situation)}

    def _why(self, action: Action) -> str:
        times = self._fails[action.index]
        return f"{action} failed {times} time{'s' * (times != 1)}, last: {self._reasons[action.index]}"


class Route:
    """The decisions of a run, without a robot: the same whether outcomes are real, scripted or imagined.

    Paper 003, section 2.6: follow the cheapest way; after a Fail, plan again from where it leads.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """Begin at the network's start, with nothing planned."""
        self.network = network
        self.situation = network.start
        self.planner = Planner(network)
        self._ahead: list[Action] = []

    @property
    def arrived(self) -> bool:
        """True if the goal is reached."""
        return self.situation == self.network.goal

    @property
    def planned(self) -> bool:
        """True if the last plan still holds: its rest remains the cheapest route while nothing fails."""
        return bool(self._ahead)

    def plan(self) -> Plan | NoWay:
        """Plan the cheapest route from here to the goal, and keep it."""
        plan = self.planner.plan(self.situation)
        if isinstance(plan, Plan):
            self._ahead = list(reversed(plan.actions))
        return plan

    @property
    def next(self) -> Action:
        """The action to do now; there is one after `plan` gave no `NoWay`."""
        return self._ahead[-1]

    def took(self, outcome: Outcome | NotStarted) -> None:
        """Note the outcome of the action that was `next`; a GiveUp changes nothing."""
        match outcome:
            case Success():
                self.situation = self._ahead.pop().target
            case Fail(reason, permanent):
                self.failed(reason, permanent)
            case Elsewhere(reason, situation):
                self.failed(reason)
                self.situation = situation
            case NotStarted(reason):
                self.failed(reason)

    def failed(self, reason: str, permanent: bool = False) -> None:
        """Note a Fail of the action that was `next`; a permanent Fail uses up all its attempts."""
        action = self.next
        self.planner.failed(action, reason, permanent=permanent)
        self._ahead = []
        self.situation = action.on_fail or self.situation
