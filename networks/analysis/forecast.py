"""How runs of a network end, exactly: the absorbing Markov chain of what the coordinator does."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import networkx as nx

from networks.network import Action, ActionNetwork, Situation
from networks.planner import SKIP_WEIGHT, Plan, Planner

from .moments import Ends, Moments, certain, merged

GOAL, NO_WAY, GIVE_UP = "goal", "no way", "give up"
_MOST_STATES = 200_000


class TooLarge(Exception):
    """A part of the network has too many states for exact figures."""


@dataclass(frozen=True)
class Chance:
    """How an attempt of an action ends; the rest is Fail."""

    success: float
    give_up: float = 0.0

    @property
    def fail(self) -> float:
        """Probability of Fail."""
        return max(0.0, 1.0 - self.success - self.give_up)


@dataclass(frozen=True)
class Forecast:
    """How a run ends and what it costs, if attempts are independent of each other."""

    goal: float
    """Probability that the goal is reached."""
    no_way: float
    """That nothing is left to try (status 3)."""
    give_up: float
    """That a person is needed (status 4)."""
    cost_s: float
    """Expected cost of a run, in [s]."""
    cost_sigma_s: float
    """Its standard deviation, in [s]."""


def forecast(network: ActionNetwork, chances: Sequence[Chance | None]) -> Forecast:
    """The exact figures.

    The chain's states are (situation, Fails of each action that can still be reached); attempts are limited,
    so it ends. What lies behind a strongly connected part is the same however the run came through it, so the
    network is gone through part by part: a `repeat` over 200 elements costs as much as one.

    Args:
        network: what can be done.
        chances: of each action, by its number; None for a skip, which always succeeds.

    Raises:
        TooLarge: a part has more than 200,000 states.
    """
    ends = _Parts(network, chances).from_start()
    total = Moments(0.0)
    for each in ends.values():
        total = total + each
    mean = total.first
    p = {name: ends.get(name, Moments(0.0)).p for name in (GOAL, NO_WAY, GIVE_UP)}
    sigma = math.sqrt(max(0.0, total.second - mean * mean))
    return Forecast(p[GOAL], p[NO_WAY], p[GIVE_UP], mean, sigma)


class _Parts:
    """The strongly connected parts of a network, from the last to the first."""

    def __init__(self, network: ActionNetwork, chances: Sequence[Chance | None]) -> None:
        self._network, self._chances = network, chances
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(network.situations)
        for action in network.actions:
            graph.add_edge(action.source, action.target)
            if action.on_fail:
                graph.add_edge(action.source, action.on_fail)
        self._graph = graph
        self._solved: dict[object, Ends] = {}

    def from_start(self) -> Ends:
        network = self._network
        parts = list(nx.strongly_connected_components(self._graph))
        of = {name: number for number, part in enumerate(parts) for name in part}
        ahead = self._way_ahead()
        ends: dict[tuple[str, bool], Ends] = {}
        for skipped in (True, False):
            last = {NO_WAY if skipped else GOAL: Moments(1.0)}
            ends[network.goal, skipped] = last
        reached = nx.descendants(self._graph, network.start) | {network.start}
        for part in parts:  # networkx gives them so that all that a part leads to comes before it
            for name in sorted(part & reached):
                for skipped in (True, False):
                    if name != network.goal and self._entered(name, of):
                        ends[name, skipped] = self._through(name, skipped, part, ahead, ends)
        return ends[network.start, False]

    def _entered(self, name: str, of: Mapping[str, int]) -> bool:
        others = self._graph.predecessors(name)
        return name == self._network.start or any(of[each] != of[name] for each in others)

    def _way_ahead(self) -> dict[str, float]:
        """From each situation, what the cheapest way to the goal weighs while nothing has failed."""
        weights: dict[tuple[str, str], float] = {}
        for action in self._network.actions:
            weight = SKIP_WEIGHT if action.binding is None else action.cost_s
            ends = action.source, action.target
            weights[ends] = min(weight, weights.get(ends, math.inf))
        back: nx.DiGraph[str] = nx.DiGraph()
        back.add_node(self._network.goal)
        back.add_weighted_edges_from((to, source, weight) for (source, to), weight in weights.items())
        return dict(nx.single_source_dijkstra_path_length(back, self._network.goal))

    def _through(
        self,
        entry: str,
        skipped: bool,
        part: set[str],
        ahead: Mapping[str, float],
        ends: Mapping[tuple[str, bool], Ends],
    ) -> Ends:
        actions = [each for each in self._network.actions if each.source in part]
        outside = sorted({t for a in actions for t in (a.target, a.on_fail) if t and t not in part})
        least = min((ahead[name] for name in outside if name in ahead), default=0.0)
        exits = {name: ahead[name] - least for name in outside if name in ahead}
        names = {name: number for number, name in enumerate([*sorted(part), *outside])}
        key = (
            names[entry],
            self._network.goal in part and names[self._network.goal],
            tuple((names[n], round(weight, 6)) for n, weight in exits.items()),
            tuple(self._row(action, names) for action in actions),
        )
        if key not in self._solved:
            goal = self._network.goal if self._network.goal in part else None
            local = _Part(
                sorted(part), actions, [self._chances[a.index] for a in actions], exits, outside, goal
            )
            found = local.solve(entry)
            self._solved[key] = {_code(name, names): moments for name, moments in found.items()}
        listed = list(names)
        shares: list[Ends] = []
        for code, first in self._solved[key].items():
            left, _, skips = code.partition(" ")
            if left in (NO_WAY.replace(" ", "_"), GIVE_UP.replace(" ", "_"), GOAL):
                shares.append({left.replace("_", " "): first})
                continue
            name = listed[int(left)]
            then = ends.get((name, skipped or bool(skips)), {NO_WAY: Moments(1.0)})
            shares.append({end: first.then(rest) for end, rest in then.items()})
        return merged(*shares)

    def _row(self, action: Action, names: Mapping[str, int]) -> tuple[object, ...]:
        chance = self._chances[action.index]
        fail = None if action.on_fail is None else names[action.on_fail]
        row = (names[action.source], names[action.target], fail, action.cost_s, action.attempts)
        return (*row, action.binding is None, chance)


def _code(name: str, names: Mapping[str, int]) -> str:
    """An end of a part, by the number of its situation."""
    plain, _, skips = name.partition("\0")
    return f"{names[plain]} {skips}".strip() if plain in names else plain.replace(" ", "_")


class _Part:
    """One strongly connected part, its exits joined to a goal at what lies ahead of them."""

    def __init__(
        self,
        situations: Sequence[str],
        actions: Sequence[Action],
        chances: Sequence[Chance | None],
        exits: Mapping[str, float],
        outside: Sequence[str],
        goal: str | None,
    ) -> None:
        self._inside, self._outside, self._chances = set(situations), set(outside), list(chances)
        end = "\0end"
        numbered = [replace(each, index=number) for number, each in enumerate(actions)]
        self._count = len(numbered)
        leads = [
            Action(name, end, None, 1.0, 1, index=self._count + number)
            for number, name in enumerate([*exits, *([goal] if goal else [])])
        ]
        known = {name: Situation(name) for name in [*situations, *outside, end]}
        graph: nx.MultiDiGraph[str] = nx.MultiDiGraph()
        graph.add_nodes_from(known)
        graph.add_edges_from((a.source, a.target, a.index, {"action": a}) for a in [*numbered, *leads])
        self._network = ActionNetwork(graph, known, (*numbered, *leads), situations[0], end)
        self._leads = [*exits.values(), *([0.0] if goal else [])]
        self._goal = goal
        self._known: dict[tuple[str, tuple[int, ...]], Ends] = {}

    def solve(self, entry: str) -> Ends:
        """The ends of runs that begin in `entry` with nothing failed."""
        return self._ends(entry, (0,) * self._count)

    def _ends(self, situation: str, fails: tuple[int, ...]) -> Ends:
        if situation == self._goal:
            return {GOAL: Moments(1.0)}
        if situation in self._outside:
            return {situation: Moments(1.0)}
        state = situation, fails
        if state not in self._known:
            if len(self._known) > _MOST_STATES:
                raise TooLarge
            self._known[state] = self._after(situation, fails)
        return self._known[state]

    def _after(self, situation: str, fails: tuple[int, ...]) -> Ends:
        plan = self._planner(fails).plan(situation)
        if not isinstance(plan, Plan):
            return {NO_WAY: Moments(1.0)}
        action = plan.actions[0]
        chance = self._chances[action.index] if action.binding is not None else None
        if chance is None:  # a skip
            step = certain(1.0, 0.0)
            ends = self._ends(action.target, fails)
            return {f"{name}\0skipped": step.then(rest) for name, rest in ends.items()}
        shares: list[Ends] = []
        cost = action.cost_s
        if chance.success > 0.0:
            step = certain(chance.success, cost)
            shares.append({n: step.then(rest) for n, rest in self._ends(action.target, fails).items()})
        if chance.give_up > 0.0:
            shares.append({GIVE_UP: certain(chance.give_up, cost)})
        if chance.fail > 1e-15:
            step = certain(chance.fail, cost)
            more = (*fails[: action.index], fails[action.index] + 1, *fails[action.index + 1 :])
            there = action.on_fail or situation
            shares.append({n: step.then(rest) for n, rest in self._ends(there, more).items()})
        return merged(*shares)

    def _planner(self, fails: tuple[int, ...]) -> Planner:
        planner = Planner(self._network)
        planner.set_fails(fails)
        for number, weight in enumerate(self._leads):
            planner.set_weight(self._count + number, weight)
        return planner
