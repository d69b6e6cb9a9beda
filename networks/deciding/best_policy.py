"""The best policy of a network, as decisions by state."""

from __future__ import annotations

from copy import copy
from typing import Literal

from handcart.networks.analysis.forecast import Forecaster
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import Chances, Policy, budget_of, visited
from handcart.networks.chains.step_maker import State, Step
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.plan_search import PlanSearch

from .best_values import BestValues, Decision
from .process import Process
from .run_figures import rule_price

PolicyName = Literal["rule", "expected_cost", "goal_probability"]
MAX_GAP = 1e-6
"""Relative difference of a value's bounds up to which it counts as found."""
GOAL_PRICE_S = 1e10
"""Price of an end short of the goal if P(goal) decides: time then only breaks ties."""


class BestPolicy:
    """Policy with the least expected cost, or with the largest probability of the goal.

    The decision in a state is computed at its first use, and then kept.
    """

    def __init__(
        self,
        network: ActionNetwork,
        chances: Chances,
        name: PolicyName = "expected_cost",
        person_s: float = 600.0,
        effort: Effort | None = None,
    ) -> None:
        """Prepare the search; nothing is settled yet.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None if it skips an element.
            name: what is best: `expected_cost` or `goal_probability`.
            person_s: price of each end short of the goal, in [s].
            effort: budget; None: twice `budget_of`.
        """
        price = GOAL_PRICE_S if name == "goal_probability" else person_s
        self.name, self._process = name, Process(network, chances, price)
        self.values = BestValues(self._process, effort or Effort(2.0 * budget_of(network)))
        self._search = PlanSearch(network)
        self._is_rule_better: bool | None = None

    @property
    def network(self) -> ActionNetwork:
        """Network in which the policy decides."""
        return self._process.network

    @property
    def process(self) -> Process:
        """The network as a Markov decision process, with outcome probabilities and costs."""
        return self._process

    def believing(self, chances: Chances, effort: Effort) -> BestPolicy:
        """Return a copy of this policy with other outcome probabilities; its decisions are not computed yet.

        Args:
            chances: outcome probabilities of each action; None for an action that only skips one of the
                elements over which a part of the network is repeated.
            effort: budget for computing decisions.
        """
        other = copy(self)
        other._process = self._process.believing(chances)
        other.values = BestValues(other._process, effort)
        other._is_rule_better = None
        return other

    def is_rule_better(self, forecaster: Forecaster | None = None) -> bool:
        """Return whether the rule, which takes the cheapest route, costs less than this best policy.

        This can only be true if the search for the best policy ended early because its budget was used up.

        Args:
            forecaster: forecaster of the same network and probabilities; None: a new one.
        """
        if self._is_rule_better is None:
            self._is_rule_better = self._rule_costs_less(forecaster)
        return self._is_rule_better

    def _rule_costs_less(self, forecaster: Forecaster | None) -> bool:
        found = self.decision(State(self.network.start, ()))
        if found.cost - found.low <= MAX_GAP * found.cost:
            return False
        if forecaster is None:
            effort = Effort(2.0 * budget_of(self.network))
            forecaster = Forecaster(self.network, self._process.chances, effort)
        forecast = forecaster.forecast()
        # Runs of the rule that were not followed to their end count as short of the goal, and as long again.
        left = forecast.unknown * (self._process.stop_price(self.network.start) + forecast.cost_s)
        return rule_price(self._process, forecaster, forecast)[0] + left < found.cost

    def state(self, situation: str, counts: dict[int, int]) -> State:
        """Return the state of a run in a situation.

        Args:
            situation: name of the situation.
            counts: Fails and renewals so far (`Attempts`) for each counter (`Action.counter`); actions that
                share attempts share a counter.
        """
        return self._process.after.at(situation, counts)

    def decision(self, state: State) -> Decision:
        """Return the best action in a state, with bounds of the expected cost."""
        return self.values.decision(state)

    def step(self, state: State) -> Step:
        """Return the best action in a state, with the states that may follow."""
        return self._step(state, self.decision(state))

    def policy(self, start: State | None = None) -> Policy:
        """Return the best decisions in the states that runs reach; those in unlikely states may be missing.

        Args:
            start: state in which the runs begin; None: the network's start without a Fail.
        """
        begin = start or State(self.network.start, ())
        self.decision(begin)
        return visited(self.network, begin, self.known_step)

    def known_step(self, state: State) -> Step | None:
        """Return the policy's decision in a state by the search so far; None if the search has not examined
        the state, or runs that follow the policy hardly ever reach it.
        """
        decision = self.values.likely(state)
        return None if decision is None else self._step(state, decision)

    def _step(self, state: State, decision: Decision) -> Step:
        if decision.action is not None:
            return self._process.step(state, decision.action)
        # No action is worth its cost: is there one at all?
        return Step(None, person=self._search.segment(state.situation, dict(state.fails)) is not None)
