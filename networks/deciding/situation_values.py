"""Least expected cost from each situation if a run gets its attempts back there: a lower bound."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.sparse import csc_array, eye_array

from handcart.networks.graph.network import Action
from handcart.robotics.numerics.arrays import FloatArray, IntArray

from .process import Process
from .stay_values import StayAction, StayValues, values_before_fails

MAX_ROUNDS = 200
"""Rounds of policy iteration; some five are usual."""
DENSE_MAX_SITUATIONS = 60
MAX_TIGHT_SITUATIONS = 30
"""Situations of a component up to which limited attempts tighten the lower bound."""
_Row = tuple[float, list[tuple[float, int]]]
"""Cost of an action in [s], with the probability and index within its component of each situation that
follows.
"""
_BETTER = 1e-12
"""Least relative improvement for which policy iteration changes an action."""


class SituationValues:
    """Lower bounds of the expected cost from each situation of a network.

    V(s) = min over actions of (cost + g K + sum of p V(t)), and at most K. K is the price of calling a person
    in s, g the action's probability of GiveUp, and p that of each situation t that the action may lead to.
    Attempts are unlimited here, so that V is at most the expected cost with limited attempts.

    Strongly connected components are solved one by one, each after those to which it leads. One step solves a
    component without a loop (Knuth 1977), policy iteration all others (Howard 1960). In components of up to
    `MAX_TIGHT_SITUATIONS` situations, V is then raised by counting the attempts of each stay (`StayValues`).
    """

    def __init__(self, process: Process) -> None:
        """Solve all components."""
        self._process = process
        self.value: dict[str, float] = {process.network.goal: 0.0}
        """Value of each situation, in [s]."""
        self._staying: dict[int, StayValues] = {}
        self._without: dict[tuple[int, frozenset[int]], Mapping[str, float]] = {}
        has_loops = any(len(names) > 1 for names in process.parts)
        for number in range(len(process.parts)):
            self.value |= self._solved(number, ())
            if has_loops:  # otherwise the states themselves are solved one by one, and need no close bound
                self.value |= self._tightened(number)

    def without(self, situation: str, out: frozenset[int]) -> float:
        """Return a lower bound of the expected cost from a situation, in [s], if some actions are excluded.

        Args:
            situation: the situation.
            out: numbers of the excluded actions, which start in the same strongly connected component.
        """
        number = self._process.part[situation]
        if not out:
            return self.value[situation]
        known = self._without.get((number, out))
        if known is None:
            known = self._without[number, out] = self._solved(number, out)
        return max(known[situation], self.value[situation])

    def with_attempts(self, number: int, attempts: FloatArray, places: IntArray) -> FloatArray:
        """Return lower bounds of the expected cost for n states of one component, by their attempts.

        Args:
            number: number of the component, which is a strongly connected component of the network.
            attempts: (n, actions) remaining attempts of each action in each state, infinite where a run does
                not use them up. The actions are those that start in the component, in the order of its
                situations.
            places: (n,) index of each state's situation within the component.

        Returns:
            (n,) lower bounds, in [s].
        """
        stays = self._stays(number)
        if stays is None:
            names = self._names(number)
            return np.array([self.value[name] for name in names])[places]
        return np.asarray(stays.values(attempts)[np.arange(len(places)), places])

    def _names(self, number: int) -> list[str]:
        return [name for name in self._process.parts[number] if name != self._process.network.goal]

    def _stays(self, number: int) -> StayValues | None:
        """Return the bounds of a component by attempts, made once; None if it is too large for them."""
        names = self._names(number)
        if not 0 < len(names) <= MAX_TIGHT_SITUATIONS:
            return None
        if number not in self._staying:
            known = [self.value[name] for name in names]
            stop = self._process.stop_price(names[0])
            self._staying[number] = StayValues(self._actions(names), known, stop)
        return self._staying[number]

    def _tightened(self, number: int) -> dict[str, float]:
        """Return values of a component that count the attempts of each stay in a situation."""
        names = self._names(number)
        if not 0 < len(names) <= MAX_TIGHT_SITUATIONS:
            return {}
        known, stop = [self.value[name] for name in names], self._process.stop_price(names[0])
        return dict(zip(names, values_before_fails(self._actions(names), known, stop), strict=True))

    def _actions(self, names: Sequence[str]) -> list[list[StayAction]]:
        inside = {name: place for place, name in enumerate(names)}
        return [[self._stay(action, inside) for action in self._process.out[name]] for name in names]

    def _stay(self, action: Action, inside: Mapping[str, int]) -> StayAction:
        process, first_fail = self._process, 1 + len(action.others)
        cost, fails, remains = process.price(action), 0.0, 0.0
        links: dict[int, float] = {}
        for number, (p, to) in enumerate(process.endings(action)):
            if to == action.source and number >= first_fail:
                fails += p
            elif to == action.source:
                remains += p
            elif to in inside:
                links[inside[to]] = links.get(inside[to], 0.0) + p
            elif p > 0.0:
                cost += p * self.value[to]
        allowed = action.allowance
        attempts = math.inf if allowed.unlimited or allowed.renewals else float(allowed.limit)
        return StayAction(cost, fails, remains, [(p, to) for to, p in links.items()], attempts)

    def _solved(self, number: int, out: Collection[int]) -> dict[str, float]:
        process = self._process
        names = [name for name in process.parts[number] if name != process.network.goal]
        rows = [[item for item in process.out[name] if item.index not in out] for name in names]
        inside = {name: place for place, name in enumerate(names)}
        options = [[self._row(action, inside) for action in actions] for actions in rows]
        stops = np.array([process.stop_price(name) for name in names])
        values = stops.copy()
        chosen = [-1] * len(names)
        for _ in range(MAX_ROUNDS):
            if not self._improve(options, values, chosen):
                break
            if len(names) > 1:
                values = _evaluated(options, chosen, stops)
        return dict(zip(names, values.tolist(), strict=True))

    def _row(self, action: Action, inside: Mapping[str, int]) -> _Row:
        """Return cost and transitions within the component; a Fail that stays is tried again."""
        process = self._process
        cost, stays, here = process.price(action), 0.0, inside[action.source]
        links: dict[int, float] = {}
        for p, to in process.endings(action):
            if to == action.source:
                stays += p
            elif to in inside:
                links[inside[to]] = links.get(inside[to], 0.0) + p
            elif p > 0.0:
                cost += p * self.value[to]
        left = 1.0 - stays
        if left <= 0.0:
            return cost, [(1.0, here)]
        return cost / left, [(p / left, to) for to, p in links.items()]

    def _improve(
        self,
        options: Sequence[Sequence[_Row]],
        values: FloatArray,
        chosen: list[int],
    ) -> bool:
        known, changed = values.tolist(), False
        for place, actions in enumerate(options):
            best = known[place] - _BETTER * max(1.0, known[place])
            for number, (cost, links) in enumerate(actions):
                found = cost + sum(p * known[to] for p, to in links)
                if found < best:
                    best, chosen[place], values[place], changed = found, number, found, True
        return changed


def _evaluated(options: Sequence[Sequence[_Row]], chosen: Sequence[int], stops: FloatArray) -> FloatArray:
    count, cost = len(chosen), stops.copy()
    rows, to, p = list[int](), list[int](), list[float]()
    for place, number in enumerate(chosen):
        if number >= 0:
            cost[place], links = options[place][number]
            for share, other in links:
                rows.append(place)
                to.append(other)
                p.append(share)
    if count <= DENSE_MAX_SITUATIONS:
        whole = np.eye(count)
        np.subtract.at(whole, (rows, to), p)
        return np.asarray(np.linalg.solve(whole, cost))
    from scipy.sparse.linalg import spsolve  # late: most networks are small

    follows = csc_array((p, (rows, to)), shape=(count, count))
    return np.asarray(spsolve((eye_array(count) - follows).tocsc(), cost))
