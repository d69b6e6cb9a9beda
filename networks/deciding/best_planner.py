"""Planner that follows the best policy, by the probabilities in the task's file."""

from __future__ import annotations

from collections.abc import Iterable

from typing_extensions import override

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.step_maker import State, Step
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.graph.planner import NoWay, Plan, Planner

from .best_policy import BestPolicy
from .best_values import Decision


def chances_of(network: ActionNetwork) -> list[Chance | None]:
    """Return the outcome probabilities of a network's actions, in the order of the network.

    The item is None for an action without a primitive, which only skips an element of a list over which the
    task repeats actions. An action without stated probabilities succeeds with probability 1.
    """
    return [None if action.binding is None else _chance(action) for action in network.actions]


def _chance(action: Action) -> Chance:
    return Chance(1.0 if action.p_success is None else action.p_success, action.p_give_up)


class BestPlanner(Planner):
    """Planner that follows the best policy, and computes each of its decisions only once.

    A plan assumes the first result of each action (`Action.target`). For a goal other than the network's, it
    is the cheapest sequence of actions to that goal.
    """

    def __init__(self, best: BestPolicy) -> None:
        """Create a planner in whose network nothing has failed."""
        super().__init__(best.network)
        self.best = best

    @override
    def plan(self, situation: str, goal: str | None = None, without: Iterable[Action] = ()) -> Plan | NoWay:
        excluded = list(without)
        if goal not in (None, self.network.goal) or excluded or self.best.is_rule_better():
            return self.plan_by_rule(situation, goal, excluded)
        return self.plan_by_policy(situation)

    def plan_by_rule(
        self, situation: str, goal: str | None = None, without: Iterable[Action] = ()
    ) -> Plan | NoWay:
        """Return the cheapest route, which the policy `rule` takes, or the reason why no route is left.

        Args:
            situation: situation in which the route begins.
            goal: situation in which it ends; None: the network's goal.
            without: actions that the route must not contain.
        """
        return super().plan(situation, goal, without)

    def plan_by_policy(self, situation: str) -> Plan | NoWay:
        """Return the actions that the best policy takes if each succeeds, or why a person is called.

        Args:
            situation: situation in which the actions begin.
        """
        state = self.best.state(situation, self.counts)
        first = self.best.decision(state)
        if first.action is None:
            rule = super().plan(situation)
            return rule if isinstance(rule, NoWay) else self._call(situation, first)
        return Plan(self._usual(state), first.cost, self._excluded())

    def step(self, state: State) -> Step:
        """Return the action that the best policy takes in a state, with the states that may follow."""
        return self.best.step(state)

    def _usual(self, state: State) -> tuple[Action, ...]:
        """Return the actions from a state on if each has its usual result."""
        found, seen = list[Action](), set[State]()
        while state.situation != self.network.goal and state not in seen:
            seen.add(state)
            step = self.step(state)
            if step.action is None or step.succeeded[0] is None:
                break
            found.append(step.action)
            state = step.succeeded[0]
        return tuple(found)

    def _call(self, situation: str, decision: Decision) -> NoWay:
        reason = f"in {situation} every action costs more than a person ({decision.cost:g} s)"
        return NoWay(situation, (), f"{reason}: a person is called", calls_person=True)
