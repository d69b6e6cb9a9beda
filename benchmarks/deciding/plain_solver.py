"""Independent solvers of small networks in plain Python: they share no code with the package.

The best policy by trials with bounds (BRTDP, McMahan, Likhachev and Gordon 2005), the rule by moving
probability from state to state.
"""

from __future__ import annotations

import heapq
import math
import random
import time
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from .random_networks import Drawn

State = tuple[str, tuple[int, ...]]
"""A situation, and the Fails of each action that can still come up there."""


class Edge(NamedTuple):
    """An action."""

    source: str
    target: str
    cost: float
    attempts: int
    p: float
    give_up: float = 0.0
    on_fail: str = ""

    @property
    def fail(self) -> float:
        """Probability of a Fail."""
        return max(0.0, 1.0 - self.p - self.give_up)


class Bounds(NamedTuple):
    """A value between two bounds."""

    low: float
    high: float


class PlainNetwork:
    """A network of edges, and what can follow each situation."""

    def __init__(self, edges: Iterable[Edge], start: str, goal: str) -> None:
        self.edges, self.start, self.goal = tuple(edges), start, goal
        follows: dict[str, set[str]] = {}
        for edge in self.edges:
            if edge.source != goal:
                follows.setdefault(edge.source, set()).update({edge.target, edge.on_fail or edge.source})
        self._ahead: dict[str, list[bool]] = {}
        for name in {start, goal, *follows, *(to for tos in follows.values() for to in tos)}:
            seen, todo = {name}, [name]
            while todo:
                for to in follows.get(todo.pop(), ()):
                    if to not in seen:
                        seen.add(to)
                        todo.append(to)
            self._ahead[name] = [edge.source in seen for edge in self.edges]

    def at(self, situation: str, fails: tuple[int, ...]) -> State:
        """Return the state in a situation, without the Fails that cannot matter there."""
        return situation, tuple(
            n if here else 0 for n, here in zip(fails, self._ahead[situation], strict=True)
        )

    def after(self, state: State, index: int) -> list[tuple[float, State]]:
        """Return the states after an action, short of the goal, each with its probability."""
        edge, fails = self.edges[index], state[1]
        more = (*fails[:index], fails[index] + 1, *fails[index + 1 :])
        found = [
            (edge.p, self.at(edge.target, fails)),
            (edge.fail, self.at(edge.on_fail or edge.source, more)),
        ]
        return [(p, to) for p, to in found if p > 1e-12 and to[0] != self.goal]

    def usable(self, state: State) -> list[int]:
        """Return the actions that can be started in a state."""
        pairs = enumerate(zip(self.edges, state[1], strict=True))
        return [index for index, (edge, n) in pairs if edge.source == state[0] and n < edge.attempts]


def best_cost(net: PlainNetwork, person: float, gap: float = 1e-5, limit_s: float = 60.0) -> Bounds:
    """Return bounds of the least expected cost, with a person's price for each end short of the goal.

    Args:
        net: the network.
        person: price of an end short of the goal.
        gap: relative difference of the bounds at which the search ends.
        limit_s: CPU time after which it ends.
    """
    heuristic = _unlimited(net, person)
    low: dict[State, float] = {}
    high: dict[State, float] = {}
    options: dict[State, list[tuple[float, list[tuple[float, State]]]]] = {}
    draws, until = random.Random(7), time.process_time() + limit_s

    def bound(state: State) -> float:
        return low.get(state, heuristic[state[0]])

    def opened(state: State) -> list[tuple[float, list[tuple[float, State]]]]:
        if state not in options:
            options[state] = [
                (net.edges[n].cost + net.edges[n].give_up * person, net.after(state, n))
                for n in net.usable(state)
            ]
        return options[state]

    def backup(state: State) -> list[tuple[float, State]]:
        least, most, chosen = person, person, list[tuple[float, State]]()
        for cost, nexts in opened(state):
            value = cost + sum(p * bound(to) for p, to in nexts)
            if value < least:
                least, chosen = value, nexts
            most = min(most, cost + sum(p * high.get(to, person) for p, to in nexts))
        low[state], high[state] = max(bound(state), least), min(high.get(state, person), most)
        return chosen

    root = net.at(net.start, (0,) * len(net.edges))
    backup(root)
    while high[root] - low[root] > gap * high[root] and time.process_time() < until:
        trail, state = [root], root
        while len(trail) < 1000:
            nexts = backup(state)
            open_ = [(p * (high.get(to, person) - bound(to)), to) for p, to in nexts]
            if sum(width for width, _ in open_) < 0.1 * gap * high[root]:
                break
            state = draws.choices([to for _, to in open_], [width for width, _ in open_])[0]
            trail.append(state)
        for state in reversed(trail):
            backup(state)
    return Bounds(low[root], high[root])


def _unlimited(net: PlainNetwork, person: float) -> dict[str, float]:
    """Return a lower bound for each situation: values without limits on attempts, iterated from 0."""
    value = {
        name: 0.0 for edge in net.edges for name in (edge.source, edge.target, edge.on_fail or edge.source)
    }
    for _ in range(5000):
        change = 0.0
        for name in value:
            if name == net.goal:
                continue
            best = person
            for edge in net.edges:
                if edge.source == name:
                    after = edge.p * value[edge.target] + edge.fail * value[edge.on_fail or name]
                    best = min(best, edge.cost + edge.give_up * person + after)
            change, value[name] = max(change, best - value[name]), best
        if change < 1e-9:
            break
    return value


class RuleEnds(NamedTuple):
    """Results of runs by the rule."""

    goal: Bounds
    """Probability of the goal."""
    time: float
    """Expected time of the runs, as far as they were followed."""
    give_up: float
    no_way: float


def rule_ends(
    net: PlainNetwork, unknown: float = 1e-6, limit_s: float = 60.0, begin: State | None = None
) -> RuleEnds:
    """Follow the rule from the start until the probability of the states ahead is small.

    Args:
        net: the network.
        unknown: probability at which it ends.
        limit_s: CPU time after which it ends.
        begin: another state to begin in than the start.
    """
    root = begin or net.at(net.start, (0,) * len(net.edges))
    mass, ahead = {root: 1.0}, 1.0
    heap = [(-1.0, root)]
    decided: dict[State, tuple[int, bool] | None] = {}
    goal = spent = given_up = lost = 0.0
    until = time.process_time() + limit_s
    while heap and ahead > unknown and time.process_time() < until:
        _, state = heapq.heappop(heap)
        share = mass.pop(state, 0.0)
        if not share:
            continue
        ahead -= share
        if state not in decided:
            decided[state] = _rule(net, state)
        choice = decided[state]
        if choice is None:
            lost += share
            continue
        index, hopes = choice
        edge = net.edges[index]
        spent += share * edge.cost
        given_up += share * edge.give_up
        fails = state[1]
        more = (*fails[:index], fails[index] + 1, *fails[index + 1 :])
        nexts = [
            (edge.p, net.at(edge.target, more if hopes else fails)),
            (edge.fail, net.at(edge.on_fail or edge.source, more)),
        ]
        for p, to in nexts:
            if to[0] == net.goal:
                goal += share * p
            elif p > 1e-12:
                ahead += share * p
                mass[to] = mass.get(to, 0.0) + share * p
                heapq.heappush(heap, (-mass[to], to))
    return RuleEnds(Bounds(goal, goal + max(0.0, ahead)), spent, given_up, lost)


def _rule(net: PlainNetwork, state: State) -> tuple[int, bool] | None:
    """Return the first action of the rule's plan, and whether it has to fail; None if no way is left."""
    weights = [
        math.inf if n >= edge.attempts else edge.cost * 2.0**n
        for edge, n in zip(net.edges, state[1], strict=True)
    ]
    return _route(net, state[0], weights, False) or _route(net, state[0], weights, True)


def _route(
    net: PlainNetwork, start: str, weights: list[float], through_fails: bool
) -> tuple[int, bool] | None:
    """Return the first action of the cheapest route; through Fails, of the one that needs the fewest."""
    known: Mapping[str, tuple[int, float]] = {start: (0, 0.0)}
    heap: list[tuple[int, float, str, tuple[int, bool] | None]] = [(0, 0.0, start, None)]
    done = set[str]()
    while heap:
        hopes, cost, here, first = heapq.heappop(heap)
        if here in done:
            continue
        done.add(here)
        if here == net.goal:
            return first
        for index, edge in enumerate(net.edges):
            if edge.source != here or weights[index] == math.inf:
                continue
            ends = [(edge.target, 0)]
            if through_fails and edge.on_fail and edge.fail > 1e-12:
                ends.append((edge.on_fail, 1))
            for to, hope in ends:
                there = hopes + hope, cost + weights[index]
                if to not in done and there < known.get(to, (10**9, math.inf)):
                    known = {**known, to: there}
                    heapq.heappush(heap, (*there, to, first or (index, bool(hope))))
    return None


def plain_network(drawn: Drawn) -> PlainNetwork:
    """Return a network of the package as a plain one."""
    edges = [
        Edge(a.source, a.target, a.cost_s, a.attempts, chance.success, chance.give_up, a.on_fail or "")
        for a, chance in zip(drawn.network.actions, drawn.chances, strict=True)
        if chance is not None
    ]
    return PlainNetwork(edges, drawn.network.start, drawn.network.goal)
