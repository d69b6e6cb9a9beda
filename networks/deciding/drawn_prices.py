"""Expected price of a policy for many draws of the probabilities at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.policy import Chances, Policy, fail_shares, success_shares
from handcart.networks.chains.step_maker import State, Step
from handcart.networks.graph.network import Action
from handcart.robotics.numerics.arrays import FloatArray

from .process import Process

MIN_LEAVING = 1e-13
"""Least probability of leaving a state, so that a policy that never ends has a price: a very large one."""


class DrawnAction(NamedTuple):
    """Outcome probabilities of one action, drawn many times from beliefs; each array is (draws,)."""

    success: Sequence[FloatArray]
    """Probability of each situation that a Success leads to, as in `Step.succeeded`."""
    fail: Sequence[FloatArray]
    """Probability of each situation that a Fail leads to, as in `Step.all_failed`."""
    give_up: FloatArray


class PricedRow(NamedTuple):
    """Cost and successors of one state of a policy, each for many draws of the outcome probabilities."""

    cost: FloatArray
    """(draws,) cost of its decision, with the prices of ends that follow at once, in [s]."""
    leads: list[tuple[FloatArray, int]]
    """Probability (draws,) of each state that follows, with the place of that state in the order."""


class DrawnPrices:
    """Expected prices of several policies of one network, for the same draws of outcome probabilities.

    The price of a run is its time, with a fixed time added for each end short of the goal.
    """

    def __init__(self, process: Process, draws: Sequence[Chances]) -> None:
        """Prepare the prices.

        Args:
            process: the network with its prices.
            draws: outcome probabilities of each action in each draw; None if it skips an element.
        """
        self._process, self._draws = process, draws
        self._actions: dict[int, DrawnAction] = {}

    def of(self, policy: Policy) -> FloatArray:
        """Return the expected price of a policy, (draws,) in [s], for each random draw of outcome
        probabilities.

        In states without a step in the policy, a person is called. The linear equations of the states' prices
        are solved by elimination for all draws at once, successors first: each price in a state's equation is
        replaced by the equation of that price. The system stays sparse, because a state's counts of Fails and
        renewals never decrease along a run.
        """
        if policy.start not in policy.steps:
            return np.full(len(self._draws), self._process.stop_price(policy.start.situation))
        order = _successors_first(policy)
        places = {state: place for place, state in enumerate(order)}
        reduced: list[PricedRow] = []
        for place, state in enumerate(order):
            row = self._row(state, policy.steps[state], places)
            reduced.append(_eliminated(place, row, reduced))
        return reduced[-1].cost

    def _row(self, state: State, step: Step, places: Mapping[State, int]) -> PricedRow:
        process, action = self._process, step.action
        stop = process.stop_price(state.situation)
        if action is None:
            return PricedRow(np.full(len(self._draws), stop), [])
        drawn, leads = self._drawn(action), list[tuple[FloatArray, int]]()
        cost: FloatArray = stop * drawn.give_up
        cost = cost + (process.person_s if action.binding is None else action.cost_s)
        for p, after in self._following(step, drawn):
            if after in places:
                leads.append((p, places[after]))
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
            results = np.array(_each(chances, lambda chance: success_shares(action, chance))).T
            causes = np.array(_each(chances, lambda chance: fail_shares(action, chance))).T
            fail = np.maximum(0.0, 1.0 - success - give_up)
            self._actions[action.index] = DrawnAction(list(success * results), list(fail * causes), give_up)
        return self._actions[action.index]


def _each(chances: Sequence[Chance], shares: Callable[[Chance], Sequence[float]]) -> list[Sequence[float]]:
    """Return the shares of each draw, which are computed once if no draw has its own."""
    if any(chance.success_shares or chance.fail_shares for chance in chances):
        return [shares(chance) for chance in chances]
    return [shares(chances[0])] * len(chances)


def _successors_first(policy: Policy) -> list[State]:
    """Return the states that runs of a policy reach, each after its successors but for circles."""
    steps, found, seen = policy.steps, list[State](), {policy.start}
    ahead = [(policy.start, steps[policy.start].following())]
    while ahead:
        state, successors = ahead[-1]
        following = next((item for item in successors if item in steps and item not in seen), None)
        if following is None:
            ahead.pop()
            found.append(state)
        else:
            seen.add(following)
            ahead.append((following, steps[following].following()))
    return found


def _eliminated(at: int, row: PricedRow, reduced: Sequence[PricedRow]) -> PricedRow:
    """Return a row that refers to later rows only.

    Args:
        at: place of the row.
        row: its cost, with the places of the rows that it refers to.
        reduced: all rows before it, each of which refers to later rows than itself only.
    """
    cost, leads = row.cost.copy(), dict[int, FloatArray]()
    for p, to in row.leads:
        leads[to] = leads[to] + p if to in leads else p
    earlier = [to for to in leads if to < at]
    heapify(earlier)
    while earlier:
        before = heappop(earlier)
        p = leads.pop(before)
        cost += p * reduced[before].cost
        for share, to in reduced[before].leads:
            if to in leads:
                leads[to] = leads[to] + p * share
            else:
                leads[to] = p * share
                if to < at:
                    heappush(earlier, to)
    if (stays := leads.pop(at, None)) is not None:
        left = np.maximum(MIN_LEAVING, 1.0 - stays)
        return PricedRow(cost / left, [(p / left, to) for to, p in leads.items()])
    return PricedRow(cost, [(p, to) for to, p in leads.items()])
