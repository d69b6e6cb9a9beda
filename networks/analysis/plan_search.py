"""Fast planner that finds the coordinator's plans in one network, from many of its states."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterable, Mapping

from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.graph.planner import SKIP_WEIGHT

_SLACK = 1e-9
"""Relative difference of costs below which both routes are searched, because sums are rounded."""


class PlanSearch:
    """Finds what `networks/graph/planner.py` plans, of ways of the same weight the same, and searches little.

    A Fail only makes ways dearer, so what is left to the goal while nothing has failed never is too much: A*
    finds the cheapest weight with it (Hart, Nilsson and Raphael, 1968), then the planner's own search, by
    Dijkstra, looks only at situations that can lie on a way as cheap.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """Prepare the search of a network."""
        self._actions = network.actions
        self._place = {name: number for number, name in enumerate(network.situations)}
        self._goal = self._place[network.goal]
        self._base = [SKIP_WEIGHT if a.binding is None else a.cost_s for a in network.actions]
        self._ways: list[list[tuple[int, tuple[int, ...]]]] = [
            [(self._place[to], tuple(edges)) for to, edges in network.graph[name].items()]
            for name in network.situations
        ]
        self._left = self._to_goal()
        self.steps = 0
        """Number of situations that the last search visited."""

    def plan(self, situation: str, fails: Mapping[int, int]) -> tuple[Action, ...] | None:
        """Return the cheapest route to the goal; None if no route leads there.

        Args:
            situation: where the route begins.
            fails: number of Fails by action number; an action with as many Fails as attempts is excluded.
        """
        self.steps = 0
        weights, start = self._weights(fails), self._place[situation]
        cost = self._cheapest(start, weights)
        if cost == math.inf:
            return None
        nodes = self._way(start, weights, cost * (1.0 + _SLACK))
        return tuple(self._best(*pair, weights) for pair in itertools.pairwise(nodes))

    def _weights(self, fails: Mapping[int, int]) -> dict[int, float]:
        """Return the present weights of the actions that failed."""
        actions, base = self._actions, self._base
        return {
            index: math.inf if count >= actions[index].attempts else math.ldexp(base[index], count)
            for index, count in fails.items()
        }

    def _weight(self, edges: Iterable[int], weights: Mapping[int, float]) -> float:
        base = self._base
        return min(weights.get(index, base[index]) for index in edges)

    def _cheapest(self, start: int, weights: Mapping[int, float]) -> float:
        left, goal = self._left, self._goal
        known = {start: 0.0}
        heap = [(left[start], start, 0.0)] if left[start] < math.inf else []
        while heap:
            _, here, came = heapq.heappop(heap)
            if here == goal:
                return came
            if came > known[here]:
                continue
            self.steps += 1
            for to, edges in self._ways[here]:
                ahead = left[to]
                if ahead == math.inf:
                    continue
                there = came + self._weight(edges, weights)
                if there < known.get(to, math.inf):
                    known[to] = there
                    heapq.heappush(heap, (there + ahead, to, there))
        return math.inf

    def _way(self, start: int, weights: Mapping[int, float], most: float) -> list[int]:
        """Return the cheapest route with the tie-break of networkx: of equal routes, the one found first."""
        left, goal = self._left, self._goal
        seen, before, done, count = {start: 0.0}, {start: start}, set(), 0
        heap = [(0.0, 0, start)]
        while heap:
            came, _, here = heapq.heappop(heap)
            if here in done:
                continue
            done.add(here)
            if here == goal:
                break
            self.steps += 1
            for to, edges in self._ways[here]:
                there = came + self._weight(edges, weights)
                if there + left[to] <= most and there < seen.get(to, math.inf):
                    count += 1
                    seen[to], before[to] = there, here
                    heapq.heappush(heap, (there, count, to))
        nodes = [goal]
        while nodes[-1] != start:
            nodes.append(before[nodes[-1]])
        return nodes[::-1]

    def _best(self, source: int, target: int, weights: Mapping[int, float]) -> Action:
        edges = next(edges for to, edges in self._ways[source] if to == target)
        return self._actions[min(edges, key=lambda index: (weights.get(index, self._base[index]), index))]

    def _to_goal(self) -> list[float]:
        """Return the remaining cost from each situation to the goal while nothing has failed."""
        back: list[list[tuple[int, float]]] = [[] for _ in self._ways]
        for here, ways in enumerate(self._ways):
            for to, edges in ways:
                back[to].append((here, self._weight(edges, {})))
        left = [math.inf] * len(back)
        left[self._goal] = 0.0
        heap = [(0.0, self._goal)]
        while heap:
            far, here = heapq.heappop(heap)
            if far > left[here]:
                continue
            for before, weight in back[here]:
                if far + weight < left[before]:
                    left[before] = far + weight
                    heapq.heappush(heap, (far + weight, before))
        return left
