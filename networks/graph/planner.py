"""The cheapest route to the goal, with failed actions made dearer."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import networkx as nx

from .belief_prior import Judged
from .network import Action, ActionNetwork
from .plan_search import SKIP_WEIGHT as SKIP_WEIGHT
from .plan_search import PlanSearch


@dataclass(frozen=True)
class Plan:
    """Planned route to a goal, with the actions to do in their order."""

    actions: tuple[Action, ...]
    cost: float
    """The sum of planning weights, in [s]."""
    excluded: tuple[Action, ...]
    """Excluded actions: those that failed as often as they may."""
    hopes: bool = False
    """True if the last action has to fail, or to have another result than its first, to lead on. Each of
    its Successes uses up an attempt, so that a run ends.
    """
    judged: Judged | None = None
    """Judgement of the policy that it follows; None where beliefs decide nothing."""


@dataclass(frozen=True)
class NoWay:
    """Result of planning if no route to the goal remains, because attempts of actions are used up."""

    situation: str
    blocking: tuple[Action, ...]
    """The actions that would lead on, had they not been used up."""
    explanation: str
    calls_person: bool = False
    """True if actions are left, and calling a person costs less than any of them."""
    judged: Judged | None = None
    """Judgement of the policy that it follows; None where beliefs decide nothing."""


class Planner:
    """Planner by the rule, which takes the cheapest route, and doubles an action's cost after each Fail.

    The planner counts the Fails of a run; the network never changes.
    """

    def __init__(self, network: ActionNetwork, search: PlanSearch | None = None) -> None:
        """Create a planner of a network in which nothing has failed.

        Args:
            network: the network.
            search: search of the same network, to be shared; None: a new one, made for the first plan.
        """
        self.network = network
        self._searches = {} if search is None else {network.goal: search}
        self.counts: dict[int, int] = {}
        """Counts of Fails by counter (`Action.counter`), as in `Attempts`; those at 0 are not included."""
        self._reasons: dict[int, tuple[int, str]] = {}

    def search(self, goal: str | None = None) -> PlanSearch:
        """Return the search for routes to a goal, created at the first call for this goal.

        Args:
            goal: situation in which the routes end; None: the network's goal.
        """
        there = self.network.goal if goal is None else goal
        if there not in self._searches:
            self._searches[there] = PlanSearch(self.network, there)
        return self._searches[there]

    def begin_again(self) -> None:
        """Forget all Fails, because the next round (repetition of the task) begins with all attempts
        available.
        """
        self.counts.clear()
        self._reasons.clear()

    def fails(self, action: Action) -> int:
        """Return the Fails that count for an action, including those of actions that share its attempts."""
        count = self.counts.get(action.counter, 0)
        return action.allowance.fails(count) if count else 0

    def failed(self, action: Action, reason: str, *, permanent: bool = False) -> None:
        """Count a Fail; a permanent one uses up all attempts.

        The last `reason` is part of the explanation if no route is left (`NoWay`).
        """
        allowed, count = action.allowance, self.counts.get(action.counter, 0)
        self.counts[action.counter] = allowed.used_up(count) if permanent else allowed.failed(count)
        times, _ = self._reasons.get(action.index, (0, ""))
        self._reasons[action.index] = times + 1, reason

    def refused(self, action: Action, reason: str) -> None:
        """Count a start that the operator refused as a Fail that shows nothing about the probabilities."""
        Planner.failed(self, action, reason)

    def hoped(self, action: Action) -> None:
        """Count a Success as one more Fail of the action, so that attempts run out.

        To be called if the plan needed the action to Fail, because only its `on_fail` leads to the goal.
        """
        Planner.failed(self, action, "it succeeded, and its Fail was needed")

    def succeeded(self, action: Action) -> bool:
        """Reset the counts of Fails of the actions whose attempts a Success of `action` renews; return
        whether a count changed.
        """
        changed = False
        for counter in self.network.renewed_by.get(action.index, ()):
            if counter in self.counts:
                before = self.counts[counter]
                self.counts[counter] = self.network.actions[counter].allowance.renewed(before)
                changed |= self.counts[counter] != before
        return changed

    def is_out(self, action: Action) -> bool:
        """Return whether an action is excluded because its attempts are used up."""
        return action.allowance.is_out(self.counts.get(action.counter, 0))

    def plan(self, situation: str, goal: str | None = None, without: Iterable[Action] = ()) -> Plan | NoWay:
        """Return the cheapest sequence of actions (the route) from `situation` to the goal.

        If the goal cannot be reached by Successes alone, the route ends before the goal, with an action that
        gives attempts back or that has to fail.

        Args:
            situation: situation in which the route begins.
            goal: situation in which it ends; None: the network's goal.
            without: actions that the route must not contain, besides those without attempts left.
        """
        search = self.search(goal)
        actions = search.plan(situation, self.counts, [action.index for action in without])
        if actions is None:
            return self._no_way(situation, goal or self.network.goal)
        weights = search.weights(actions, self.counts)
        there = goal or self.network.goal
        leads_on = not actions or actions[-1].target == there
        hopes = not leads_on and actions[-1].index not in search.renewing(self.counts)
        return Plan(actions, sum(weights, 0.0), self._excluded(), hopes)

    def _excluded(self) -> tuple[Action, ...]:
        shared, actions = self.network.shared, self.network.actions
        out = (c for c, count in self.counts.items() if actions[c].allowance.is_out(count))
        return tuple(sorted((a for c in out for a in shared[c]), key=lambda action: action.index))

    def _no_way(self, situation: str, goal: str) -> NoWay:
        graph = self.network.graph
        reached = self._reached(situation)
        useful = nx.ancestors(graph, goal) | {goal}
        blocking = tuple(
            action
            for action in self._excluded()
            if action.source in reached and not (useful - reached).isdisjoint(action.leads_to)
        )
        words = "; ".join(self._why(action) for action in blocking) or f"nothing leads from {situation} there"
        return NoWay(situation, blocking, f"no way left from {situation} to {goal}: {words}")

    def _reached(self, situation: str) -> set[str]:
        usable: Iterable[Action] = (a for a in self.network.actions if not self.is_out(a))
        left: nx.DiGraph[str] = nx.DiGraph([(a.source, to) for a in usable for to in a.leads_to])
        left.add_node(situation)
        return {situation, *nx.descendants(left, situation)}

    def _why(self, action: Action) -> str:
        times, reason = self._reasons.get(action.index, (0, "others used up the attempts that it shares"))
        return f"{action} failed {times} time{'s' * (times != 1)}, last: {reason}"
