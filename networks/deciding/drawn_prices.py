"""Expected price of a policy for many draws of the probabilities at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.policy import Chances, Policy, fail_shares, success_shares
from handcart.networks.chains.step_maker import State, Step
from handcart.networks.graph.network import Action
from handcart.robotics.numerics.arrays import FloatArray

from .process import Process

MAX_SWEEPS = 500
SWEEP_TOLERANCE = 1e-6
"""Largest relative change of a price in the last sweep."""


class DrawnAction(NamedTuple):
    """Outcome probabilities of one action in many draws; each array is (draws,)."""

    success: Sequence[FloatArray]
    """Probability of each situation that a Success leads to, as in `Step.succeeded`."""
    fail: Sequence[FloatArray]
    """Probability of each situation that a Fail leads to, as in `Step.all_failed`."""
    give_up: FloatArray


class PricedRow(NamedTuple):
    """Cost and successors of one state of a policy, in many draws."""

    cost: FloatArray
    """(draws,) cost of its decision, with the prices of ends that follow at once, in [s]."""
    leads: list[tuple[FloatArray, int]]
    """Probability (draws,) of each state that follows, with the number of that state."""


class DrawnPrices:
    """Prices of policies in one network, by the same draws."""

    def __init__(self, process: Process, draws: Sequence[Chances]) -> None:
        """Prepare the prices.

        Args:
            process: the network with its prices.
            draws: outcome probabilities of each action in each draw; None for a skip.
        """
        self._process, self._draws = process, draws
        self._actions: dict[int, DrawnAction] = {}

    def of(self, policy: Policy) -> FloatArray:
        """Return the expected price of a policy in each draw, (draws,) in [s].

        In states that were not looked at, a person is called. States are taken in the policy's order, in
        which successors come first; where chance leads in circles, the sweeps are repeated (Gauss and
        Seidel).
        """
        if policy.start not in policy.steps:
            return np.full(len(self._draws), self._process.stop_price(policy.start.situation))
        numbers = {state: number for number, state in enumerate(policy.steps)}
        rows = [self._row(state, step, numbers) for state, step in policy.steps.items()]
        prices: FloatArray = np.zeros((len(rows), len(self._draws)))
        for _ in range(MAX_SWEEPS if policy.circles else 1):
            before = prices.copy()
            for number, row in enumerate(rows):
                price = prices[number]
                price[:] = row.cost
                for p, following in row.leads:
                    price += p * prices[following]
            if np.all(np.abs(prices - before) <= SWEEP_TOLERANCE * (1.0 + prices)):
                break
        found: FloatArray = prices[numbers[policy.start]]
        return found

    def _row(self, state: State, step: Step, numbers: Mapping[State, int]) -> PricedRow:
        process, action = self._process, step.action
        stop = process.stop_price(state.situation)
        if action is None:
            return PricedRow(np.full(len(self._draws), stop), [])
        drawn, leads = self._drawn(action), list[tuple[FloatArray, int]]()
        cost: FloatArray = stop * drawn.give_up
        cost = cost + (process.person_s if action.binding is None else action.cost_s)
        for p, after in self._following(step, drawn):
            if after in numbers:
                leads.append((p, numbers[after]))
            elif after.situation != process.network.goal:
                cost = cost + p * process.stop_price(after.situation)
        return PricedRow(cost, leads)

    def _following(self, step: Step, drawn: DrawnAction) -> Iterator[tuple[FloatArray, State]]:
        pairs = zip((*drawn.success, *drawn.fail), (*step.succeeded, *step.all_failed), strict=True)
        return ((p, after) for p, after in pairs if after is not None)

    def _drawn(self, action: Action) -> DrawnAction:
        if action.index not in self._actions:
            chances = [draw[action.index] or Chance(1.0) for draw in self._draws]
            if action.binding is None:
                chances = [Chance(1.0)] * len(self._draws)
            success = np.array([chance.success for chance in chances])
            give_up = np.array([chance.give_up for chance in chances])
            results = np.array([success_shares(action, chance) for chance in chances]).T
            causes = np.array([fail_shares(action, chance) for chance in chances]).T
            fail = np.maximum(0.0, 1.0 - success - give_up)
            self._actions[action.index] = DrawnAction(list(success * results), list(fail * causes), give_up)
        return self._actions[action.index]
