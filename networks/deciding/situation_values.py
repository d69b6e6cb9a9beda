"""Least expected cost from each situation if attempts are not counted: a lower bound that is often close."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, eye_array

from handcart.networks.graph.network import Action
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

from .process import Process

MAX_ROUNDS = 200
"""Rounds of policy iteration; some five are usual."""
DENSE_MAX_SITUATIONS = 60
MAX_TIGHT_SITUATIONS = 30
"""Situations of a component up to which excluded actions tighten the lower bound."""
MAX_TIGHT_SWEEPS, TIGHT_CHANGE_S = 40, 1e-6
"""Maximum number of sweeps that tighten the bound, and the improvement in [s] below which they end."""
_Row = tuple[float, list[tuple[float, int]]]
"""Cost of an action in [s], with the probability and index within its component of each situation that
follows.
"""
_BETTER = 1e-12
"""Least relative improvement for which policy iteration changes an action."""


class SituationValues:
    """Lower bounds of the expected cost from each situation of a network, computed without counting attempts.

    V(s) = min over actions of (cost + g K + sum of p V(t)), and at most K. K is the price of calling a person
    in s, g the action's probability of GiveUp, and p that of each situation t that the action may lead to.
    Attempts are unlimited here, so that V is at most the expected cost with limited attempts.

    Strongly connected components are solved one by one, each after those to which it leads. One step solves a
    component without a loop (Knuth 1977), policy iteration all others (Howard 1960).
    """

    def __init__(self, process: Process) -> None:
        """Solve all components."""
        self._process = process
        self.value: dict[str, float] = {process.network.goal: 0.0}
        """Value of each situation, in [s]."""
        self._tight: dict[int, dict[bytes, FloatArray]] = {}
        """Values (situations,) of each component for excluded actions, which are packed as bits."""
        self._without: dict[tuple[int, frozenset[int]], Mapping[str, float]] = {}
        self._in_arrays: dict[int, tuple[FloatArray, FloatArray, IntArray, IntArray]] = {}
        for number in range(len(process.parts)):
            self.value |= self._solved(number, ())

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
        return known[situation]

    def without_each(self, number: int, out: BoolArray, places: IntArray) -> FloatArray:
        """Return lower bounds of the expected cost for n states of one component, with excluded actions.

        Args:
            number: number of the component, which is a strongly connected component of the network.
            out: (n, actions) mask of the actions excluded in each state. The actions are those that start in
                the component, in the order of its situations.
            places: (n,) index of each state's situation within the component.

        Returns:
            (n,) lower bounds, in [s].
        """
        process = self._process
        names = [name for name in process.parts[number] if name != process.network.goal]
        known = np.array([self.value[name] for name in names])
        if len(names) > MAX_TIGHT_SITUATIONS or not out.any():
            return known[places]
        cases, case = np.unique(_packed(out), return_inverse=True)
        tight = self._tight.setdefault(number, {})
        keys = [key.tobytes() for key in cases]
        new = [place for place, key in enumerate(keys) if key not in tight]
        if new:
            first = np.empty(len(cases), np.int64)
            first[case] = np.arange(len(case))
            values = self._tightened(number, names, out[first[new]])
            tight.update((keys[place], row) for place, row in zip(new, values, strict=True))
        return np.asarray(np.array([tight[key] for key in keys])[case, places])

    def _tightened(self, number: int, names: Sequence[str], cases: BoolArray) -> FloatArray:
        """Return lower bounds (n, situations) for a component without some actions, in [s].

        Args:
            number: number of the component.
            names: its situations.
            cases: (n, actions) the excluded actions, in the order of the component's situations.
        """
        cost, follows, first, able = self._arrays(number, names)
        stops = np.array([self._process.stop_price(name) for name in names])
        values = np.tile([self.value[name] for name in names], (len(cases), 1))
        for _ in range(MAX_TIGHT_SWEEPS):
            options = np.where(cases, np.inf, cost + values @ follows.T)
            better = np.tile(stops, (len(cases), 1))
            better[:, able] = np.minimum(stops[able], np.minimum.reduceat(options, first, axis=1))
            change = float(np.max(better - values))
            np.maximum(values, better, out=values)
            if change < TIGHT_CHANGE_S:
                break
        return values

    def _arrays(self, number: int, names: Sequence[str]) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
        """Return costs and transitions of the actions of a component, made once.

        Returns:
            Costs (actions,) in [s]; probabilities (actions, situations); and for each situation that has
                actions, the index of its first action and the index of the situation, both (k,).
        """
        if number not in self._in_arrays:
            inside = {name: place for place, name in enumerate(names)}
            rows = [[self._row(action, inside) for action in self._process.out[name]] for name in names]
            every = [row for item in rows for row in item]
            follows = np.zeros((len(every), len(names)))
            for place, (_, links) in enumerate(every):
                for p, to in links:
                    follows[place, to] += p
            count = np.array([len(item) for item in rows])
            able = np.flatnonzero(count)
            first = (np.cumsum(count) - count)[able]
            self._in_arrays[number] = np.array([cost for cost, _ in every]), follows, first, able
        return self._in_arrays[number]

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


def _packed(out: BoolArray) -> NDArray[Any]:
    """Return the rows of a mask (n, k) as one value each, (n,): an integer, or bytes if k is above 64."""
    words = -(-out.shape[1] // 64)
    whole = np.zeros((len(out), 64 * words), bool)
    whole[:, : out.shape[1]] = out
    packed = np.ascontiguousarray(np.packbits(whole, axis=1))
    return packed.view(np.uint64 if words == 1 else f"V{8 * words}")[:, 0]


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
