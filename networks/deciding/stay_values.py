"""Lower bounds of the expected cost if attempts are counted only during each stay in a situation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

FIRST_SWEEPS, SWEEPS = 40, 5
"""Maximum number of sweeps over the situations: before the first Fail, and for each batch of states."""
MIN_CHANGE_SHARE = 1e-7
"""Improvement below which the sweeps end, relative to the price of calling a person."""
MIN_LEAVING = 1e-12
"""Least probability that an attempt leaves its situation; below it, an action is of no use there."""
MAX_SWAPPED_ACTIONS = 4
"""Actions out of one situation up to which exchanges of neighbours sort faster than NumPy."""


class StayAction(NamedTuple):
    """An action as the stay in its situation sees it."""

    cost: float
    """Price of an attempt, plus the value of the other components to which it may lead, in [s]."""
    fails: float
    """Probability that an attempt Fails and leaves the situation as it is."""
    remains: float
    """Probability that an attempt succeeds and leaves the situation as it is."""
    links: Sequence[tuple[float, int]]
    """Other situations of the component that may follow: probability, and index of each."""
    attempts: float
    """Attempts before the first Fail; infinite if a run does not use them up."""


class _Try(NamedTuple):
    """An action, given that its attempts go on until one of them leaves the situation."""

    column: int
    """Index of the action in its component."""
    cost: float
    links: Sequence[tuple[float, int]]


class StayValues:
    """Lower bounds of the expected cost from the situations of one component, for given remaining attempts.

    The attempts of each action are limited while a run stays in its situation, and given back when the run
    comes to the situation again. This only helps a run, so that the values are at most the expected cost.

    With unlimited returns, the best order of the actions during a stay is known: the action whose expected
    cost would be least if it were tried until it leaves the situation is tried first, as often as it may be,
    then the next one, as long as they cost less than a person (Mitten 1960, least-cost testing sequence).
    """

    def __init__(self, actions: Sequence[Sequence[StayAction]], known: Sequence[float], stop: float) -> None:
        """Prepare the actions.

        Args:
            actions: the actions out of each situation of the component.
            known: (situations,) lower bounds before the first Fail, in [s].
            stop: price of calling a person, in [s].
        """
        self._fail = np.array([_fail_share(action) for item in actions for action in item])
        self._tries, self._stop, self._known = _tries(actions), stop, np.array(known)
        self._order = np.argsort(self._known, kind="stable").tolist()

    def values(self, attempts: FloatArray) -> FloatArray:
        """Return lower bounds of the expected cost from each situation, in [s].

        Args:
            attempts: (n, actions) remaining attempts of each action, in the order of the situations; infinite
                where they are not limited.

        Returns:
            (n, situations) lower bounds.
        """
        # Situations and actions come first, so that each step works on contiguous rows.
        spent = np.where(attempts.T > 0.0, self._fail[:, None] ** np.maximum(attempts.T, 1.0), 1.0)
        values = np.tile(self._known[:, None], len(attempts))
        for _ in range(SWEEPS):
            change = 0.0
            for place in self._order:
                better = self._stayed(self._tries[place], values, spent)
                change = max(change, float((better - values[place]).max(initial=0.0)))
                np.maximum(values[place], better, out=values[place])
            if change <= MIN_CHANGE_SHARE * self._stop:
                break
        return values.T

    def _stayed(self, tries: Sequence[_Try], values: FloatArray, spent: FloatArray) -> FloatArray:
        """Return the least expected cost (n,) of a stay in one situation, in [s].

        Args:
            tries: the actions out of the situation.
            values: (situations, n) values of the situations that follow.
            spent: (actions, n) probability that all remaining attempts of an action Fail and stay.
        """
        costs, shares = list[FloatArray](), list[FloatArray]()
        for item in tries:
            cost = np.full(values.shape[1], item.cost)
            for p, to in item.links:
                cost += p * values[to]
            costs.append(cost)
            shares.append(spent[item.column])
        _sort(costs, shares)
        value = np.full(values.shape[1], self._stop)
        for cost, share in zip(reversed(costs), reversed(shares), strict=True):
            np.minimum(value, cost + share * (value - cost), out=value)
        return value


def values_before_fails(
    actions: Sequence[Sequence[StayAction]], known: Sequence[float], stop: float
) -> list[float]:
    """Return the lower bounds of `StayValues` before the first Fail, in [s].

    Args:
        actions: the actions out of each situation of the component.
        known: (situations,) other lower bounds, in [s].
        stop: price of calling a person, in [s].
    """
    values, tries = list(known), _tries(actions)
    # One state: plain numbers are faster than arrays.
    spent = [_fail_share(action) ** action.attempts for item in actions for action in item]
    order = sorted(range(len(values)), key=values.__getitem__)
    for _ in range(FIRST_SWEEPS if len(values) > 1 else 1):
        change = 0.0
        for place in order:
            costs = [
                (item.cost + sum([p * values[to] for p, to in item.links]), spent[item.column])
                for item in tries[place]
            ]
            value = stop
            for cost, share in sorted(costs, reverse=True):
                value = min(value, cost + share * (value - cost))
            change, values[place] = max(change, value - values[place]), max(value, values[place])
        if change <= MIN_CHANGE_SHARE * stop:
            break
    return values


def _fail_share(action: StayAction) -> float:
    """Return the probability that an attempt that does not simply remain Fails and stays."""
    return min(1.0, action.fails / (1.0 - action.remains)) if action.remains < 1.0 else 1.0


def _tries(actions: Sequence[Sequence[StayAction]]) -> list[list[_Try]]:
    """Return for each situation the actions that can leave it."""
    found, column = list[list[_Try]](), 0
    for item in actions:
        tries = list[_Try]()
        for number, action in enumerate(item):
            if (left := 1.0 - action.fails - action.remains) > MIN_LEAVING:
                links = [(p / left, to) for p, to in action.links]
                tries.append(_Try(column + number, action.cost / left, links))
        found.append(tries)
        column += len(item)
    return found


def _sort(costs: list[FloatArray], shares: list[FloatArray]) -> None:
    """Sort two lists of k arrays (n,) in place, such that the costs ascend for each of the n."""
    count = len(costs)
    if count > MAX_SWAPPED_ACTIONS:
        order = np.argsort(costs, axis=0)
        costs[:] = np.take_along_axis(np.array(costs), order, axis=0)
        shares[:] = np.take_along_axis(np.array(shares), order, axis=0)
        return
    for last in range(count - 1, 0, -1):
        for here in range(last):
            one, two = costs[here], costs[here + 1]
            swaps = one > two
            if swaps.any():
                costs[here], costs[here + 1] = np.minimum(one, two), np.maximum(one, two)
                one, two = shares[here], shares[here + 1]
                shares[here], shares[here + 1] = np.where(swaps, two, one), np.where(swaps, one, two)
