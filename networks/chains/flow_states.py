"""States of the rule as rows of integers, each with the probability that a run comes to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.networks.graph.network import ActionNetwork
from handcart.robotics.numerics.arrays import FloatArray, IntArray, Uint16Array

from .step_maker import Aftermath, State

MAX_CODE = 2**62
"""Upper limit of a code in one integer; larger codes take several."""


class FlowStates(NamedTuple):
    """States of a network, each with the probability that a run comes to it, and the cost of runs up to
    there.
    """

    counts: Uint16Array
    """(n, counters) number of Fails of each counter, in the order of `ActionNetwork.shared`."""
    place: IntArray
    """(n,) number of the situation of each state."""
    mass: FloatArray
    """(n, 3 or 6) p, E[C; state] and E[C²; state] of the cost C so far in [s] (`Moments`).

    The second three columns are for the runs that have left an element of a repeat undone.
    """

    @property
    def p(self) -> FloatArray:
        """(n,) probability that a run comes to each state."""
        return np.asarray(self.mass[:, ::3].sum(axis=1))

    def at(self, chosen: IntArray) -> FlowStates:
        """Return a selection of these states: the m states at the indices `chosen` (m,)."""
        return FlowStates(self.counts[chosen], self.place[chosen], self.mass[chosen])


class StateCodes:
    """Conversion between a network's states and rows of integers (situation, counts of Fails).

    Equal rows can be merged into one.
    """

    def __init__(self, network: ActionNetwork, after: Aftermath) -> None:
        """Prepare the conversion for a network."""
        self._names, self._counters = list(network.situations), list(network.shared)
        self.place = {name: number for number, name in enumerate(self._names)}
        """Number of each situation."""
        goal = network.goal
        every = [
            [name != goal and after.matters(name, counter) for counter in self._counters]
            for name in self._names
        ]
        self._keeps = np.array(every, np.uint16)
        self._factors = self._code_factors(network)

    def _code_factors(self, network: ActionNetwork) -> IntArray:
        """Return the factors (counters, integers) by which numbers of Fails enter a code, a mixed radix."""
        words = [[0] * len(self._counters)]
        factor = len(self._names)
        for number, counter in enumerate(self._counters):
            width = network.actions[counter].allowance.width
            if factor * width > MAX_CODE:
                words.append([0] * len(self._counters))
                factor = 1
            words[-1][number] = factor
            factor *= width
        return np.array(words, np.int64).T

    def one(self, state: State, mass: FloatArray) -> FlowStates:
        """Return a table of states (`FlowStates`) with one state as its only row.

        Args:
            state: the state.
            mass: (3 or 6,) a row of `FlowStates.mass`: probability that a run comes to the state, and cost in
                [s] and squared cost in [s²] of these runs; three more are the same for runs that have left an
                element of a `repeat` undone.
        """
        counts = np.zeros((1, len(self._counters)), np.uint16)
        for counter, fails in state.fails:
            counts[0, self._counters.index(counter)] = fails
        return FlowStates(counts, np.array([self.place[state.situation]]), mass[None, :])

    def state(self, counts: Uint16Array, place: int) -> State:
        """Return the state of a run, given its situation and its earlier Fails.

        Args:
            counts: (counters,) number of Fails by each counter, in the order of `ActionNetwork.shared`.
            place: number of the situation.
        """
        failed = np.flatnonzero(counts)
        fails = sorted((self._counters[number], int(counts[number])) for number in failed)
        return State(self._names[place], tuple(fails))

    def forgotten(self, states: FlowStates) -> FlowStates:
        """Return the states with those counts of Fails set to 0 that no longer matter.

        A count no longer matters if none of the actions whose Fails it counts can be reached from the state.
        """
        return states._replace(counts=states.counts * self._keeps[states.place])

    def merged(self, every: Sequence[FlowStates]) -> FlowStates:
        """Return the states of several `FlowStates` together, sorted by their counts of Fails.

        Equal states become one, with the sum of their probabilities and of their costs (`mass`).
        """
        counts, place, mass = (np.concatenate(item) for item in zip(*every, strict=True))
        if not len(place):
            return FlowStates(counts, place, mass)
        codes = counts.astype(np.int64) @ self._factors
        codes[:, 0] += place
        order = np.argsort(codes[:, 0]) if codes.shape[1] == 1 else np.lexsort(codes.T)
        codes = codes[order]
        differs = np.append(True, (codes[1:] != codes[:-1]).any(axis=1))
        chosen, number = order[differs], np.empty(len(order), np.int64)
        number[order] = np.cumsum(differs) - 1
        total = np.empty((len(chosen), mass.shape[1]))
        for moment, values in enumerate(mass.T):  # `np.add.reduceat` takes longer
            total[:, moment] = np.bincount(number, values, len(chosen))
        return FlowStates(counts[chosen], place[chosen], total)
