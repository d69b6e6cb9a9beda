"""The rule's routes for many counts of Fails at once."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.plan_search import SKIP_WEIGHT, hopes_of
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, Uint16Array

NO_ACTION = -1
TIE_SLACK = 1e-9
"""Relative difference of costs below which two routes count as equal, because sums are rounded."""


class CountRoutes(NamedTuple):
    """Cheapest routes from all situations, each given by its first action, for n combinations of earlier
    Fails.
    """

    action: IntArray
    """(situations, n) number of the first action; `NO_ACTION` if no route leads to the goal."""
    is_tied: BoolArray
    """(situations, n) True if another first action leads to a route of the same cost."""
    has_to_fail: BoolArray
    """(situations, n) True if the route needs a Fail of this action."""


class _Way(NamedTuple):
    """Actions that lead from one situation to another, or the Fail of one action that does."""

    source: int
    target: int
    actions: tuple[int, ...]
    fails: int


class RouteFinder:
    """Search for the cheapest routes to the goal, by relaxation (Bellman, 1958), for many combinations of
    Fails at once.

    An action's weight is its cost, doubled for each of its Fails; an action without attempts left is
    excluded. The routes are the same as those that `PlanSearch` finds for one combination.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """Prepare a network, which must have no further results, renewals or unlimited attempts."""
        self._place = {name: number for number, name in enumerate(network.situations)}
        self._goal = self._place[network.goal]
        column = {counter: number for number, counter in enumerate(network.shared)}
        self._column = [column[action.counter] for action in network.actions]
        self._weight = [_weights(a.cost_s, a.attempts, a.binding is None) for a in network.actions]
        plain = list(self._ways(network))
        by_fails = [
            _Way(self._place[a.source], self._place[to], (a.index,), 1)
            for a in network.actions
            for to in hopes_of(a)
            if a.source != network.goal
        ]
        self._plain, self._hoping = self._in_order(plain), self._in_order([*plain, *by_fails])

    def _ways(self, network: ActionNetwork) -> Iterator[_Way]:
        for name in network.situations:
            if name != network.goal:
                for to, edges in network.graph[name].items():
                    yield _Way(self._place[name], self._place[to], tuple(sorted(edges)), 0)

    def _in_order(self, ways: Sequence[_Way]) -> list[_Way]:
        """Return the ways, those near the goal first: few rounds of relaxation then suffice."""
        far = np.full(len(self._place), np.inf)
        far[self._goal] = 0.0
        for _ in range(len(far)):
            before = far.copy()
            for way in ways:
                far[way.source] = min(far[way.source], far[way.target] + self._weight[way.actions[0]][0])
            if np.array_equal(before, far):
                break
        return sorted(ways, key=lambda way: (float(far[way.source]), way.source))

    def routes(self, counts: Uint16Array) -> CountRoutes:
        """Return the cheapest routes on which every action succeeds, for n combinations of earlier Fails.

        Args:
            counts: (n, counters) number of Fails by each counter, in the order of `ActionNetwork.shared`;
                actions that share their attempts have one counter.
        """
        return self._search(counts, self._plain)

    def hoping(self, counts: Uint16Array) -> CountRoutes:
        """Return routes that include Fails, as few as possible, for states from which no route of Successes
        is left.

        Args:
            counts: (n, counters) number of earlier Fails by each counter, in the order of
                `ActionNetwork.shared`; actions that share their attempts have one counter.
        """
        return self._search(counts, self._hoping)

    def _search(self, counts: Uint16Array, ways: Sequence[_Way]) -> CountRoutes:
        size = len(self._place), len(counts)
        weights = [self._weight[a][counts[:, column]] for a, column in enumerate(self._column)]
        weight = [_least_weight(weights, way) for way in ways]
        fails, cost = np.full(size, np.inf), np.full(size, np.inf)
        fails[self._goal] = cost[self._goal] = 0.0
        plain = not any(way.fails for way in ways)
        changed = [True] * len(cost)  # situations to which a route was found or improved in the last round
        while any(changed):
            now, changed = changed, [False] * len(cost)
            for way, own in zip(ways, weight, strict=True):
                if now[way.target] or changed[way.target]:
                    better = _shorten(cost, way, own) if plain else _relax(fails, cost, way, own)
                    changed[way.source] |= better
        if plain:
            fails = np.where(cost < math.inf, 0.0, math.inf)
        return _first_actions(ways, weights, fails, cost)


def _first_actions(
    ways: Sequence[_Way], weights: Sequence[FloatArray], fails: FloatArray, cost: FloatArray
) -> CountRoutes:
    """Return the first actions of the cheapest routes.

    Args:
        ways: the ways, as in `RouteFinder`.
        weights: weight (n,) of each action in [s].
        fails: (situations, n) number of Fails that the cheapest route needs.
        cost: (situations, n) cost of this route in [s].
    """
    action, count = np.full(cost.shape, NO_ACTION), np.zeros(cost.shape, np.int64)
    needs, nearly = np.zeros(cost.shape, bool), cost + TIE_SLACK * cost
    is_plain = not any(way.fails for way in ways)
    for way in reversed(ways):
        own = _least_weight(weights, way)
        source, come = way.source, cost[way.target] + own
        best = come < math.inf
        if not is_plain:
            best &= fails[way.target] + way.fails == fails[source]
        count[source] += best & (come <= nearly[source])
        best &= come <= cost[source]
        for item in reversed(way.actions):
            chosen = best & (weights[item] == own) if len(way.actions) > 1 else best
            action[source][chosen] = item
            if not is_plain:
                needs[source][chosen] = way.fails > 0
    return CountRoutes(action, count > 1, needs)


def _least_weight(weights: Sequence[FloatArray], way: _Way) -> FloatArray:
    """Return the weight (n,) of the cheapest action of a way, in [s]."""
    if len(way.actions) == 1:
        return weights[way.actions[0]]
    return np.asarray(np.minimum.reduce([weights[action] for action in way.actions]))


def _shorten(cost: FloatArray, way: _Way, weight: FloatArray) -> bool:
    """Improve the costs (situations, n) by a way with weights (n,); return whether any became less."""
    come, known = cost[way.target] + weight, cost[way.source]
    better = bool((come < known).any())
    if better:
        np.minimum(known, come, out=known)
    return better


def _relax(fails: FloatArray, cost: FloatArray, way: _Way, weight: FloatArray) -> bool:
    """Improve the routes (situations, n) by an action or Fail with its weights (n,); fewer Fails come
    first.

    Returns:
        Whether any became better.
    """
    come = cost[way.target] + weight
    there = np.where(come < math.inf, fails[way.target] + way.fails, math.inf)
    better = (there < fails[way.source]) | ((there == fails[way.source]) & (come < cost[way.source]))
    found = bool(better.any())
    if found:
        fails[way.source][better], cost[way.source][better] = there[better], come[better]
    return found


def _weights(cost_s: float, attempts: int, is_skip: bool) -> FloatArray:
    """Return the weight of an action, in [s], for each number of its Fails from 0 on."""
    base = SKIP_WEIGHT if is_skip else cost_s
    return np.array([*(math.ldexp(base, fails) for fails in range(attempts)), math.inf])
