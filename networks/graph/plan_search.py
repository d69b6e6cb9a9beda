"""Search for the cheapest route to the goal, from many states of one network."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from .cheapest_tree import CheapestTree
from .network import Action, ActionNetwork

SKIP_WEIGHT = 1e12
"""Weight of leaving an element undone, in [s]: more than all that could still be tried."""
_SLACK = 1e-9
"""Relative difference of costs below which both routes are searched, because sums are rounded."""


class Segment(NamedTuple):
    """First actions of a plan, up to the goal or to a situation from which a new search plans the rest."""

    actions: tuple[Action, ...]
    end: str
    hopes: bool = False
    """True if the last action leads on by its Fail, or by another result than its first, and no route of
    Successes is left.
    """
    renews: bool = False
    """True if the last action gives attempts back that lead on, and no other route is left."""


class PlanSearch:
    """Search for the cheapest route, with the result of Dijkstra's algorithm but less work.

    Fails only make routes more expensive, so that the cost to the goal without any Fail is a lower bound.
    With this bound, A* finds the cost of the cheapest route (Hart, Nilsson and Raphael, 1968). Then
    Dijkstra's search, with the tie-break of networkx, visits only situations on routes of this cost. It ends
    at the first situation that all of these routes have in common.
    """

    def __init__(self, network: ActionNetwork, goal: str | None = None) -> None:
        """Prepare the search of a network; a given goal replaces its own."""
        self._network, self._actions = network, network.actions
        self._place = {name: number for number, name in enumerate(network.situations)}
        self._names = tuple(network.situations)
        self._goal = self._place[network.goal if goal is None else goal]
        self._base = [SKIP_WEIGHT if a.binding is None else a.cost_s for a in network.actions]
        self._ways = self._joined_ways()
        self._tree = CheapestTree(self._ways, self._base, self._goal)
        self._doubled: dict[tuple[int, int], dict[int, float]] = {}
        """Weights of the actions of a counter of Fails, by counter and count."""
        self._searches: dict[str, PlanSearch] = {}
        """Searches of routes to actions that give attempts back."""
        self._hopes: list[list[tuple[int, int, int]]] | None = None
        self.steps = 0
        """Number of situations that the last search visited."""

    def _joined_ways(self) -> list[list[tuple[int, tuple[int, ...]]]]:
        """Return the ways out of each situation, in the order of the network's graph."""
        place = self._place
        found: list[dict[int, tuple[int, ...]]] = [{} for _ in place]
        for action in self._actions:
            out, to = found[place[action.source]], place[action.target]
            out[to] = (*out[to], action.index) if to in out else (action.index,)
        return [list(out.items()) for out in found]

    def plan(
        self, situation: str, fails: Mapping[int, int], without: Iterable[int] = ()
    ) -> tuple[Action, ...] | None:
        """Return the cheapest route to the goal; None if no route leads there.

        If no route of Successes is left, the route ends before the goal, with an action that gives attempts
        back or that has to fail.

        Args:
            situation: situation in which the route begins.
            fails: counts of Fails and renewals (`Attempts`), by the actions' `counter`.
            without: numbers of further actions that are excluded.
        """
        found: list[Action] = []
        weights = {**self._weights(fails), **dict.fromkeys(without, math.inf)}
        here, steps, spoiled = self._place[situation], 0, self._tree.spoiled(weights)
        while here != self._goal:
            if not self._tree.is_spoiled(here, spoiled) and (rest := self._only_route(here)) is not None:
                found += rest
                break
            segment = self._segment(here, weights, fails, spoiled)
            steps += self.steps
            if segment is None:
                self.steps = steps
                return None
            found += segment.actions
            here = self._place[segment.end]
            if segment.hopes or segment.renews:
                break
        self.steps = steps
        return tuple(found)

    def _only_route(self, here: int) -> list[Action] | None:
        """Return the cheapest route while nothing has failed; None if another one costs the same, or none
        is left.
        """
        left, found, ways, base, cheapest = self._tree.left, list[int](), self._ways, self._base, self._cheap
        while here != self._goal:
            most, to, action = left[here] * (1.0 + _SLACK), -1, -1
            if most == math.inf:
                return None
            for target, edges in ways[here]:
                index = edges[0] if len(edges) == 1 else cheapest(edges)
                if base[index] + left[target] <= most:
                    if action >= 0:
                        return None
                    to, action = target, index
            if action < 0:
                return None
            found.append(action)
            here = to
        return [self._actions[index] for index in found]

    def _cheap(self, edges: Sequence[int]) -> int:
        """Return the cheapest of some actions while nothing has failed, of several the first."""
        return min(edges, key=lambda index: (self._base[index], index))

    def segment(self, situation: str, fails: Mapping[int, int]) -> Segment | None:
        """Return the first actions of the cheapest plan; None if no plan leads to the goal.

        They lead to the goal, or to a situation from which the search has to begin again.

        Args:
            situation: situation in which the plan begins.
            fails: counts of Fails and renewals (`Attempts`), by the actions' `counter`.
        """
        return self._segment(self._place[situation], self._weights(fails), fails)

    def weights(self, actions: Iterable[Action], fails: Mapping[int, int]) -> list[float]:
        """Return the weight of each action in planning, in [s].

        Args:
            actions: the actions.
            fails: counts of Fails and renewals (`Attempts`), by the actions' `counter`.

        Returns:
            The action's cost, doubled for each of its Fails; infinite if the action is excluded.
        """
        known, base = self._weights(fails), self._base
        return [known.get(action.index, base[action.index]) for action in actions]

    def weight(self, action: Action, fails: Mapping[int, int]) -> float:
        """Return the weight of an action in planning, in [s]: its cost, doubled for each of its Fails;
        infinite if excluded.

        Args:
            action: the action.
            fails: counts of Fails and renewals (`Attempts`), by the actions' `counter`.
        """
        return self._weights(fails).get(action.index, self._base[action.index])

    def _segment(
        self,
        start: int,
        weights: Mapping[int, float],
        fails: Mapping[int, int],
        spoiled: Sequence[tuple[int, int]] = (),
    ) -> Segment | None:
        """Return the first actions of the cheapest route, up to the next situation that all equally cheap
        routes share.

        Args:
            start: number of the situation where the route begins.
            weights: weights of the actions that failed, in [s], by number.
            fails: counts of Fails by counter.
            spoiled: intervals of situations (`CheapestTree.spoiled`) in which the segment must not end.
        """
        self.steps = 0
        cost = self._cheapest(start, weights)
        if cost == math.inf:
            return self._renewing(start, weights, fails) or self._hoping(start, weights)
        nodes = self._way(start, weights, cost * (1.0 + _SLACK), spoiled)
        pairs = itertools.pairwise(nodes)
        return Segment(tuple(self._best(*pair, weights) for pair in pairs), self._names[nodes[-1]])

    def _weights(self, fails: Mapping[int, int]) -> dict[int, float]:
        """Return the present weights, in [s], of the actions that failed, by number."""
        known, found = self._doubled, dict[int, float]()
        for failed in fails.items():
            if failed not in known:
                known[failed] = self._doubled_weights(*failed)
            found.update(known[failed])
        return found

    def _doubled_weights(self, counter: int, count: int) -> dict[int, float]:
        """Return the weights, in [s], of all actions that share a counter, after a count of Fails."""
        shared, base = self._network.shared, self._base
        return {
            action.index: math.inf
            if action.allowance.is_out(count)
            else math.ldexp(base[action.index], action.allowance.fails(count))
            for action in shared[counter]
        }

    def _weight(self, edges: Sequence[int], weights: Mapping[int, float]) -> float:
        base = self._base
        if len(edges) == 1:
            return weights.get(edges[0], base[edges[0]])
        return min(weights.get(index, base[index]) for index in edges)

    def _cheapest(self, start: int, weights: Mapping[int, float]) -> float:
        left, goal = self._tree.left, self._goal
        spoiled = self._tree.spoiled(weights)
        known = {start: 0.0}
        heap = [(left[start], start, 0.0)] if left[start] < math.inf else []
        while heap:
            _, here, came = heapq.heappop(heap)
            if came > known[here]:
                continue
            if here == goal or not self._tree.is_spoiled(here, spoiled):
                return came + left[here]
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

    def _way(
        self, start: int, weights: Mapping[int, float], most: float, spoiled: Sequence[tuple[int, int]]
    ) -> list[int]:
        """Return the cheapest route up to where all such routes meet; of equal ones, that of networkx."""
        left, goal = self._tree.left, self._goal
        seen, before, done, count = {start: 0.0}, {start: start}, set[int](), 0
        heap = [(0.0, 0, start)]
        while True:
            came, _, here = heapq.heappop(heap)
            if here in done:
                continue
            done.add(here)
            all_meet = here != start and len(seen) == len(done)
            if here == goal or (all_meet and not self._tree.is_spoiled(here, spoiled)):
                break
            self.steps += 1
            for to, edges in self._ways[here]:
                there = came + self._weight(edges, weights)
                if there + left[to] <= most and there < seen.get(to, math.inf):
                    count += 1
                    seen[to], before[to] = there, here
                    heapq.heappush(heap, (there, count, to))
        nodes = [here]
        while nodes[-1] != start:
            nodes.append(before[nodes[-1]])
        return nodes[::-1]

    def _best(self, source: int, target: int, weights: Mapping[int, float]) -> Action:
        edges = next(edges for to, edges in self._ways[source] if to == target)
        return self._actions[min(edges, key=lambda index: (weights.get(index, self._base[index]), index))]

    def _renewing(self, start: int, weights: Mapping[int, float], fails: Mapping[int, int]) -> Segment | None:
        """Return the cheapest route to an action after whose Success a route to the goal is open again."""
        found: list[tuple[float, int]] = []
        for index, fresh in self.renewing(fails).items():
            action = self._actions[index]
            after = {**weights, **self._weights(fresh)}
            cost = self._search_to(action.source)._cheapest(start, weights)
            cost += weights.get(index, self._base[index]) + self._cheapest(self._place[action.target], after)
            if cost < math.inf:
                found.append((cost, index))
        if not found:
            return None
        last = self._actions[min(found)[1]]
        way = self._search_to(last.source).plan(self._names[start], fails)
        assert way is not None
        return Segment((*way, last), last.target, renews=True)

    def renewing(self, fails: Mapping[int, int]) -> dict[int, dict[int, int]]:
        """Return the actions whose Success makes excluded actions possible again, because it resets their
        counts of Fails.

        Args:
            fails: counts of Fails and renewals (`Attempts`), by the actions' `counter`.

        Returns:
            By the action's number, the counters that it renews, each with its count after the renewal.
        """
        found: dict[int, dict[int, int]] = {}
        for index, counters in self._network.renewed_by.items():
            for counter in counters:
                allowed, count = self._actions[counter].allowance, fails.get(counter, 0)
                if allowed.is_out(count) and not allowed.is_out(allowed.renewed(count)):
                    found.setdefault(index, {})[counter] = allowed.renewed(count)
        return found

    def _search_to(self, situation: str) -> PlanSearch:
        if situation not in self._searches:
            self._searches[situation] = PlanSearch(self._network, situation)
        return self._searches[situation]

    def _hoping(self, start: int, weights: Mapping[int, float]) -> Segment | None:
        """Return the route that needs the fewest Fails or unusual results; of several the cheapest."""
        ways = self._hope_ways()
        if ways is None or start == self._goal:
            return None
        known: dict[int, tuple[int, float]] = {start: (0, 0.0)}
        before: dict[int, tuple[int, int, int]] = {}
        heap = [(0, 0.0, start)]
        while heap:
            hopes, came, here = heapq.heappop(heap)
            if (hopes, came) > known[here]:
                continue
            if here == self._goal:
                return self._up_to_hope(start, before)
            self.steps += 1
            for to, index, hope in ways[here]:
                there = hopes + hope, came + weights.get(index, self._base[index])
                if there[1] < math.inf and there < known.get(to, (len(ways), math.inf)):
                    known[to], before[to] = there, (here, index, hope)
                    heapq.heappush(heap, (*there, to))
        return None

    def _up_to_hope(self, start: int, before: Mapping[int, tuple[int, int, int]]) -> Segment:
        steps, here = list[tuple[int, int, int]](), self._goal
        while here != start:
            steps.append((here, *before[here][1:]))
            here = before[here][0]
        steps.reverse()
        last = next(number for number, (_, _, hope) in enumerate(steps) if hope)
        actions = tuple(self._actions[index] for _, index, _ in steps[: last + 1])
        return Segment(actions, self._names[steps[last][0]], True)

    def _hope_ways(self) -> list[list[tuple[int, int, int]]] | None:
        """Return the ways out of each situation, with those by Fails; None if no Fail leads elsewhere."""
        if self._hopes is None:
            self._hopes = []
            if any(hopes_of(action) for action in self._actions):
                self._hopes = [[] for _ in self._ways]
                for action in self._actions:
                    out = self._hopes[self._place[action.source]]
                    out.append((self._place[action.target], action.index, 0))
                    out += [(self._place[to], action.index, 1) for to in hopes_of(action)]
        return self._hopes or None


def hopes_of(action: Action) -> list[str]:
    """Return the situations to which an action may lead otherwise than by its usual Success (`target`): by
    Fails or by further results.

    Situations that are reached with probability 0 are left out.
    """
    others = [other.target for other in action.others if other.p != 0.0]
    certain = action.p_success is not None and action.p_success + action.p_give_up >= 1.0 - 1e-12
    never = {ending.target for ending in action.fail_endings if ending.p == 0.0} - {action.on_fail}
    return others if certain else [*others, *(to for to in action.fail_situations if to not in never)]
