"""The cheapest routes to the goal while nothing has failed."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Mapping, Sequence

Ways = Sequence[Sequence[tuple[int, tuple[int, ...]]]]
"""For each situation, by number, the following situations with the numbers of the actions that lead there."""


class CheapestTree:
    """Tree of the cheapest routes from all situations to the goal, before any action has failed.

    A Fail of an action makes the routes of one subtree more expensive. The situations of each subtree have
    consecutive numbers in a depth-first order, so that two comparisons show whether a situation is in the
    subtree.
    """

    def __init__(self, ways: Ways, base: Sequence[float], goal: int) -> None:
        """Compute the tree.

        Args:
            ways: the network.
            base: weight of each action, in [s].
            goal: number of the goal.
        """
        self.left = [math.inf] * len(ways)
        """Cost of the route from each situation to the goal, in [s]; infinity without a route."""
        self._next = [-1] * len(ways)
        self._action = [-1] * len(ways)
        order = self._search(ways, base, goal)
        self._source = {self._action[here]: here for here in order if here != goal}
        self._enter, self._leave = self._intervals(order, len(ways))

    def _search(self, ways: Ways, base: Sequence[float], goal: int) -> list[int]:
        """Search from the goal backwards; return the situations in the order of their costs."""
        back: list[list[tuple[int, float, int]]] = [[] for _ in ways]
        for here, out in enumerate(ways):
            for to, edges in out:
                best = edges[0] if len(edges) == 1 else min(edges, key=lambda index: (base[index], index))
                back[to].append((here, base[best], best))
        left, done, order = self.left, [False] * len(ways), []
        left[goal] = 0.0
        heap = [(0.0, goal)]
        while heap:
            far, here = heapq.heappop(heap)
            if done[here]:
                continue
            done[here] = True
            order.append(here)
            for before, weight, action in back[here]:
                if far + weight < left[before]:
                    left[before] = far + weight
                    self._next[before], self._action[before] = here, action
                    heapq.heappush(heap, (far + weight, before))
        return order

    def _intervals(self, order: Sequence[int], count: int) -> tuple[list[int], list[int]]:
        size = [1] * count
        for here in reversed(order[1:]):
            size[self._next[here]] += size[here]
        enter, free = [0] * count, [1] * count
        for here in order[1:]:
            parent = self._next[here]
            enter[here] = enter[parent] + free[parent]
            free[parent] += size[here]
        return enter, [begin + item for begin, item in zip(enter, size, strict=True)]

    def spoiled(self, failed: Mapping[int, float]) -> list[tuple[int, int]]:
        """Return the situations whose cheapest routes contain a failed action.

        Args:
            failed: weights of the failed actions by the actions' numbers; only the numbers are used.

        Returns:
            Intervals of the situations' numbers in depth-first order, each as its first number and the number
                after its last one.
        """
        sources = (self._source[index] for index in failed if index in self._source)
        return [(self._enter[here], self._leave[here]) for here in sources]

    def is_spoiled(self, here: int, spoiled: Iterable[tuple[int, int]]) -> bool:
        """Return whether the cheapest route of a situation contains a failed action.

        Args:
            here: number of the situation in the network.
            spoiled: intervals of numbers of the situations whose cheapest routes contain a failed action, in
                depth-first order (result of the method `spoiled`).
        """
        number = self._enter[here]
        for enter, leave in spoiled:  # noqa: SIM110 (a generator takes twice as long)
            if enter <= number < leave:
                return True
        return False
