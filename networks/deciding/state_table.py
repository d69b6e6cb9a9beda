"""States of one component that were looked at, with their options and bounds of their values."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, Uint16Array

from .growing_array import GrowingArray
from .situation_values import SituationValues
from .state_rows import StateRows

STOP_CHOICE = -1
"""Choice of calling a person."""
NEW_STATE = -1


class Choices(NamedTuple):
    """Best option (action) in each state of a `StateTable`, and its cost, computed from given costs of the
    states that follow.
    """

    cost: FloatArray
    """(states,) least expected cost, in [s]; infinite for states that were not expanded."""
    option: IntArray
    """(states,) number of the option, or `STOP_CHOICE`."""


class StateTable:
    """Table of the states of a strongly connected component of a network, with bounds of their costs.

    `ComponentSearch` fills it. The costs are expected costs from a state on.

    An expanded state also has its options (the actions that can be started) and their transitions. States
    outside the component that directly follow one inside are included; the search sets their bounds.
    """

    def __init__(self, rows: StateRows, bounds: SituationValues, part: int) -> None:
        """Create a table without a state.

        Args:
            rows: the states as rows.
            bounds: lower bounds by situation.
            part: number of the component.
        """
        self.rows, self._bounds, self._part = rows, bounds, part
        self._numbers: dict[bytes, int] = {}
        real, whole, mask = np.zeros(0), np.zeros(0, np.int64), np.zeros(0, bool)
        self._states = GrowingArray(np.zeros((0, 1 + len(rows.counters)), np.uint16))
        self._low, self._high, self._stop = GrowingArray(real), GrowingArray(real), GrowingArray(real)
        self._expanded = GrowingArray(mask)
        self._price, self._left = GrowingArray(real), GrowingArray(real)
        self._state, self._action = GrowingArray(whole), GrowingArray(whole)
        self._ends, self._p, self._to = (
            GrowingArray(np.zeros(1, np.int64)),
            GrowingArray(real),
            GrowingArray(whole),
        )
        self._order, self._first = GrowingArray(whole), GrowingArray(whole)
        self._follows: csr_array | None = None
        """(options, states) probability of each state after each option."""
        self._can_stay = False
        """True if some option may leave its state as it is."""
        self._ranks: list[IntArray] | None = None
        """Number of the first option of each state, of the second, and so on; of the first if missing."""

    @property
    def states(self) -> Uint16Array:
        """(states, 1 + counters) situation and counts of Fails of all states, as rows of `StateRows`."""
        return self._states.all

    @property
    def low(self) -> FloatArray:
        """(states,) lower bound of the least expected cost from each state to the end of the run, in [s]."""
        return self._low.all

    @property
    def high(self) -> FloatArray:
        """(states,) upper bound of the least expected cost from each state to the end of the run, in [s]."""
        return self._high.all

    @property
    def stop(self) -> FloatArray:
        """Price of calling a person in each state, (states,) in [s]."""
        return self._stop.all

    @property
    def expanded(self) -> BoolArray:
        """(states,) True for states whose options (actions that can be started) are known."""
        return self._expanded.all

    @property
    def transitions(self) -> int:
        """Number of transitions from all states whose options (actions that can be started) are known."""
        return len(self._p.all)

    def number(self, key: bytes) -> int | None:
        """Return the number of a state, given its row as bytes (`StateRows.key`); None if it is new."""
        return self._numbers.get(key)

    def add(self, rows: Uint16Array) -> IntArray:
        """Add states that are not in the table yet, and return the numbers (n,) of all given states.

        The lower bound of a new state's cost is computed from its situation, without the actions that have
        reached their limit of Fails. The upper bound is the cost of ending the run in the situation.

        Args:
            rows: (n, 1 + counters) states: index of the situation, then the number of Fails by each counter.
        """
        numbers, new = self._numbers, list[int]()
        keys = np.ascontiguousarray(rows).view(f"V{rows.shape[1] * rows.itemsize}")[:, 0].tolist()
        known = numbers.get
        found = np.array([known(key, NEW_STATE) for key in keys], np.int64)
        for place in np.flatnonzero(found == NEW_STATE).tolist():
            key = keys[place]
            if key not in numbers:
                numbers[key] = len(numbers)
                new.append(place)
            found[place] = numbers[key]
        if new:
            self._append(rows[new])
        return found

    def _append(self, rows: Uint16Array) -> None:
        places = rows[:, 0].astype(np.int64)
        stop = self.rows.stop_price[places]
        low = np.array([self._bounds.value[name] for name in self.rows.names])[places]
        here = places < self.rows.inside
        low[here] = self._bounds.with_attempts(self._part, self.rows.attempts(rows[here]), places[here])
        self._states.extend(rows)
        self._low.extend(np.minimum(low, stop))
        self._high.extend(stop)
        self._stop.extend(stop)
        self._expanded.extend(np.zeros(len(rows), bool))

    def expand(self, numbers: IntArray) -> IntArray:
        """Compute the options (actions that can be started) of states that have no options in the table yet.

        Args:
            numbers: (n,) numbers of these states in the table.

        Returns:
            Numbers (n,) of the options that are the best by the present lower bounds, or `STOP_CHOICE`.
        """
        if not numbers.size:
            return np.zeros(0, np.int64)
        rows = self.rows
        after = rows.following(self.states[numbers])
        state, size = numbers[after.state], len(after.state)
        to = self.add(after.rows)
        own = to == state[after.option]
        stays = np.bincount(after.option[own], after.p[own], size)
        count = np.bincount(after.option[~own], minlength=size)
        before = len(self._price.all)
        self._price.extend(rows.price[after.action])
        self._left.extend(np.asarray(1.0 - stays, np.float64))
        self._state.extend(state)
        self._action.extend(after.action)
        self._ends.extend(self._ends.all[-1] + np.cumsum(count))
        self._p.extend(after.p[~own])
        self._to.extend(to[~own])
        able, first = np.unique(after.state, return_index=True)
        self._order.extend(numbers[able])
        self._first.extend(before + first)
        self.expanded[numbers] = True
        unable = np.setdiff1d(numbers, numbers[able], assume_unique=True)
        self.low[unable] = self.stop[unable]
        return self._best_of(numbers, before)

    def _best_of(self, numbers: IntArray, first: int) -> IntArray:
        """Return the best options (n,) of states by the lower bounds, given the number of their first one."""
        state, ends = self._state.all[first:], self._ends.all[first:]
        products = self._p.all[ends[0] :] * self.low[self._to.all[ends[0] :]]
        ahead = np.diff(np.concatenate(([0.0], np.cumsum(products)))[ends - ends[0]])
        with np.errstate(divide="ignore"):
            cost = (self._price.all[first:] + ahead) / self._left.all[first:]
        order = np.lexsort((cost, state))
        able, places = np.unique(state[order], return_index=True)
        best = order[places]
        chosen = np.full(len(self.expanded), STOP_CHOICE)
        chosen[able] = np.where(cost[best] < self.stop[able], first + best, STOP_CHOICE)
        return np.asarray(chosen[numbers])

    def choices(self, values: FloatArray) -> Choices:
        """Return the best option (action) of each state, and its cost, for assumed costs of the states that
        follow.

        Args:
            values: (states,) assumed least expected cost from each state on, in [s].
        """
        cost, option = np.full(len(values), np.inf), np.full(len(values), STOP_CHOICE)
        expanded = self.expanded
        cost[expanded] = self.stop[expanded]
        if len(self._first.all):
            priced = self._priced(values)
            least = np.full(len(values), np.inf)
            least[self._order.all] = np.minimum.reduceat(priced, self._first.all)
            best = np.flatnonzero(priced <= least[self._state.all])[::-1]
            option[self._state.all[best]] = best
            option[least >= self.stop] = STOP_CHOICE
            cost = np.minimum(cost, least)
        return Choices(cost, option)

    def improved(self, values: FloatArray) -> FloatArray:
        """Return the least expected costs (states,) after one step of value iteration, in [s].

        Args:
            values: (states,) present costs, in [s]; states whose options (possible actions) are not computed
                yet keep their costs.
        """
        found = np.where(self.expanded, self.stop, values)
        if len(self._first.all):
            order = self._order.all
            found[order] = np.minimum(found[order], self._least(values))
        return found

    def raise_low(self, sweeps: int) -> None:
        """Raise the lower bounds by some sweeps of value iteration over all states."""
        self._sweep(self.low, np.maximum, sweeps)

    def reduce_high(self, sweeps: int) -> None:
        """Reduce the upper bounds by some sweeps of value iteration over all states."""
        self._sweep(self.high, np.minimum, sweeps)

    def _sweep(self, values: FloatArray, better: np.ufunc, sweeps: int) -> None:
        # States without an option have their final bounds: calling a person is all that is left there.
        order = self._order.all
        if len(order):
            stop = self.stop[order]
            for _ in range(sweeps):
                values[order] = better(values[order], np.minimum(stop, self._least(values)))

    def _least(self, values: FloatArray) -> FloatArray:
        """Return the least cost of an option (states with options,), in [s], in the order of `_order`."""
        priced, first = self._priced(values), self._first.all
        if self._ranks is None or len(self._ranks[0]) != len(first):
            count = np.diff(np.append(first, len(priced)))
            self._ranks = [np.where(count > rank, first + rank, first) for rank in range(count.max())]
        least: FloatArray = priced[self._ranks[0]]
        for number in self._ranks[1:]:  # few options each: `np.minimum.reduceat` takes longer
            np.minimum(least, priced[number], out=least)
        return least

    def _priced(self, values: FloatArray) -> FloatArray:
        shape = len(self._price.all), len(values)
        if self._follows is None or self._follows.shape != shape:
            self._follows = csr_array((self._p.all, self._to.all, self._ends.all), shape)
            self._can_stay = bool((self._left.all != 1.0).any())
        priced: FloatArray = self._follows @ values
        priced += self._price.all
        if self._can_stay:
            with np.errstate(divide="ignore"):
                priced /= self._left.all
        return priced

    def reached(self, roots: IntArray, option: IntArray) -> IntArray:
        """Return the states (k,) that are visited if each state's chosen option is taken, ascending by
        number.

        The states `roots`, from which it starts, are included.

        Args:
            roots: (n,) numbers of the states to start from.
            option: (states,) number of the option chosen in each state, or `STOP_CHOICE`.
        """
        seen = np.zeros(len(option), bool)
        seen[roots] = True
        ahead, place = roots, np.empty(len(option), np.int64)
        while len(ahead):
            to = self._successors(option[ahead])
            to = to[~seen[to]]
            seen[to] = True
            place[to] = np.arange(len(to))  # of equal ones the last
            ahead = to[place[to] == np.arange(len(to))]
        return np.flatnonzero(seen)

    def _successors(self, options: IntArray) -> IntArray:
        """Return the numbers of the states that may follow some options, with repetitions."""
        return self._to.all[self._transitions_of(options[options != STOP_CHOICE])[1]]

    def _transitions_of(self, options: IntArray) -> tuple[IntArray, IntArray]:
        """Return how many transitions each option (n,) has, and the numbers of all of them."""
        begin = self._ends.all[options]
        count = self._ends.all[options + 1] - begin
        return count, np.repeat(begin - np.cumsum(count) + count, count) + np.arange(count.sum())

    def after(self, options: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the transitions to other states by some options (actions started in a state).

        Args:
            options: (n,) numbers of the options; `STOP_CHOICE` has no transitions.

        Returns:
            Three arrays (k,) over the transitions: index of the option in `options`, number of the state that
                follows, and the transition's probability given that the state does not remain the same.
        """
        acting = np.flatnonzero(options != STOP_CHOICE)
        chosen = options[acting]
        count, places = self._transitions_of(chosen)
        p = self._p.all[places] / np.repeat(self._left.all[chosen], count)
        return np.repeat(acting, count), self._to.all[places], p

    def action(self, option: int) -> int:
        """Return the action of an option (an action that can be started in a state of the table), as its
        index in `StateRows.actions`.

        Args:
            option: number of the option in the table.
        """
        return int(self._action.all[option])

    def prices(self, states: IntArray, options: IntArray) -> FloatArray:
        """Return the expected costs (n,), in [s], from entering each state until the chosen option leaves it.

        Args:
            states: (n,) numbers of the states.
            options: (n,) number of the option chosen in each state; with `STOP_CHOICE` the run ends in the
                state, and the cost is the state's entry in `stop`.
        """
        cost = self.stop[states].copy()
        acts = options != STOP_CHOICE
        cost[acts] = self._price.all[options[acts]] / self._left.all[options[acts]]
        return cost
