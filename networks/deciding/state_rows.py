"""States of one component of a network as rows of integers, with the states that follow them."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from handcart.networks.chains.step_maker import State
from handcart.networks.graph.attempts import MAX_ATTEMPTS
from handcart.networks.graph.network import Action
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, Uint16Array

from .process import MIN_PROBABILITY, Process

GOAL_ROW = -1
_Ending = tuple[float, int, bool]
"""Probability, index of the situation in `StateRows.names`, and whether it follows a Fail."""


class Following(NamedTuple):
    """Actions (options) that can be started in given states, and the transitions from each option to the
    states that may follow.
    """

    state: IntArray
    """(options,) number of the state in which each option can be started, ascending."""
    action: IntArray
    """(options,) index in `StateRows.actions` of each option's action."""
    option: IntArray
    """(transitions,) number of the option to which each transition belongs."""
    p: FloatArray
    """(transitions,) probability of each transition."""
    rows: Uint16Array
    """(transitions, 1 + counters) row of the state to which each transition leads, as in `StateRows`."""


class StateRows:
    """Conversion between states and rows of integers, for one strongly connected component of a network.

    States outside the component that directly follow one inside have rows, too. A row (1 + counters,) is the
    index of a situation in `names`, then the number of Fails by each of `counters`; 0 for a counter whose
    actions can no longer be started from there.
    """

    def __init__(self, process: Process, part: int, carried: Sequence[int] = ()) -> None:
        """Prepare the arrays of a component.

        Args:
            process: the network.
            part: number of the component.
            carried: counters of Fails from beyond the component that a run has brought back into it.
        """
        self._process, network = process, process.network
        inside = [name for name in process.parts[part] if name != network.goal]
        self.actions: list[Action] = [action for name in inside for action in process.out[name]]
        endings = [_endings(process, action) for action in self.actions]
        names = dict.fromkeys([*inside, *(to for ending in endings for _, to, _ in ending)])
        names.pop(network.goal, None)
        self.names = list(names)
        """Situations of the component, followed by those just beyond it."""
        self.inside = len(inside)
        """Number of situations in the component."""
        self._place = {name: place for place, name in enumerate(self.names)} | {network.goal: GOAL_ROW}
        self.counters = [*counters_of(process, part), *carried]
        self._column = {counter: column for column, counter in enumerate(self.counters)}
        self._no_fails = array("H", bytes(2 * (1 + len(self.counters))))
        self._keeps = self._kept()
        self._prepare_actions()
        self._prepare_endings(
            [[(p, self._place[to], fails) for p, to, fails in ending] for ending in endings]
        )
        self.price = np.array([process.price(action) for action in self.actions])
        """(actions,) price of starting each action, in [s]."""
        self.stop_price = np.array([process.stop_price(name) for name in self.names])
        """(situations,) price of a run that ends there, in [s]."""

    def _kept(self) -> Uint16Array:
        after = self._process.after
        every = [[after.matters(name, counter) for counter in self.counters] for name in self.names]
        return np.array(every, np.uint16).reshape(len(self.names), len(self.counters))

    def _prepare_actions(self) -> None:
        allowed = [action.allowance for action in self.actions]
        self._counter = np.array([self._column[action.counter] for action in self.actions], np.int64)
        self._width = np.array([attempts.width for attempts in allowed], np.int64)
        self._most = np.array([attempts.most for attempts in allowed], np.int64)
        self._last = np.array(
            [MAX_ATTEMPTS if attempts.unlimited else attempts.limit for attempts in allowed], np.int64
        )
        self._returns = np.array([bool(attempts.renewals) for attempts in allowed])
        self._unlimited = np.array([attempts.unlimited for attempts in allowed])
        sources = [self._place[action.source] for action in self.actions]
        self._first = np.searchsorted(sources, np.arange(self.inside + 1))
        renewed_by = self._process.network.renewed_by
        self._renews = {
            place: [self._column[c] for c in renewed_by[action.index] if c in self._column]
            for place, action in enumerate(self.actions)
            if action.index in renewed_by
        }

    def _prepare_endings(self, endings: Sequence[Sequence[_Ending]]) -> None:
        """Pad the endings of all actions to the same number."""
        most = max(map(len, endings), default=0)
        shape = len(endings), most
        self._p, self._to, self._fails = np.zeros(shape), np.full(shape, GOAL_ROW), np.zeros(shape, bool)
        for place, ending in enumerate(endings):
            for number, (p, to, fails) in enumerate(ending):
                self._p[place, number], self._to[place, number] = p, to
                self._fails[place, number] = fails

    def key(self, state: State) -> bytes:
        """Return the row of a state (situation and counts of Fails) as bytes, for use as a key."""
        row, column = self._no_fails[:], self._column
        row[0] = self._place[state.situation]
        for counter, count in state.fails:
            row[1 + column[counter]] = count
        return row.tobytes()

    def row(self, state: State) -> Uint16Array:
        """Return the row (1, 1 + counters) of a state: the index of its situation, and the number of Fails of
        each counter (actions that share their attempts).
        """
        return np.frombuffer(self.key(state), np.uint16)[None, :]

    def state(self, row: Uint16Array) -> State:
        """Return the state of a row (1 + counters,), which holds a situation and counts of Fails."""
        counts: Mapping[int, int] = {
            self.counters[column]: int(row[1 + column]) for column in np.flatnonzero(row[1:])
        }
        return self._process.after.at(self.names[int(row[0])], counts)

    def attempts(self, rows: Uint16Array) -> FloatArray:
        """Return the remaining attempts (n, actions) of each action, infinite if a run does not use them up.

        Actions whose attempts may be given back count as unlimited.

        Args:
            rows: (n, 1 + counters) index of the situation and counts of Fails of each state, as in
                `StateRows`.
        """
        left = self._most - rows[:, 1 + self._counter].astype(np.int64) % self._width
        left = np.where(self._unlimited & (left > 0), np.inf, np.maximum(0, left))
        return np.where(self._returns, np.inf, left)

    def following(self, rows: Uint16Array) -> Following:
        """Return the actions that can be started in n given states, and the states that follow each action.

        Transitions to the goal are omitted.

        Args:
            rows: (n, 1 + counters) states: index of the situation, then the number of Fails by each counter.
        """
        places = rows[:, 0].astype(np.int64)
        count = self._first[places + 1] - self._first[places]
        state = np.repeat(np.arange(len(rows)), count)
        action = np.arange(len(state)) + np.repeat(self._first[places] - np.cumsum(count) + count, count)
        counts = rows[state, 1 + self._counter[action]].astype(np.int64)
        fails = counts % self._width[action]
        usable = fails < self._most[action]
        state, action, counts, fails = state[usable], action[usable], counts[usable], fails[usable]
        failed = counts + (fails < self._last[action])
        option, number = np.nonzero((self._p[action] > 0.0) & (self._to[action] != GOAL_ROW))
        after = rows[state[option]]
        acts = action[option]
        at_fail = self._fails[acts, number]
        after[at_fail, 1 + self._counter[acts[at_fail]]] = failed[option[at_fail]]
        self._renew(after, acts, at_fail)
        to = self._to[acts, number]
        after[:, 0] = to
        after[:, 1:] *= self._keeps[to]
        return Following(state, action, option, self._p[acts, number], after)

    def _renew(self, after: Uint16Array, acts: IntArray, at_fail: BoolArray) -> None:
        """Give attempts back in the rows (n, 1 + counters) that follow a Success, in place.

        Args:
            after: (n, 1 + counters) rows of the following states.
            acts: (n,) index of the action before each.
            at_fail: (n,) True for rows that follow a Fail.
        """
        for place, columns in self._renews.items():
            chosen = np.flatnonzero((acts == place) & ~at_fail)
            for column in columns:
                allowed = self._process.network.actions[self.counters[column]].allowance
                renewals, fails = np.divmod(after[chosen, 1 + column].astype(np.int64), allowed.width)
                begins_again = chosen[(fails > 0) & (renewals < allowed.renewals)]
                again = after[begins_again, 1 + column].astype(np.int64) // allowed.width + 1
                after[begins_again, 1 + column] = again * allowed.width


def _endings(process: Process, action: Action) -> list[tuple[float, str, bool]]:
    """Return the situations that an action may lead to, with probability and whether it is a Fail."""
    first_fail = 1 + len(action.others)
    found = [(p, to, number >= first_fail) for number, (p, to) in enumerate(process.endings(action))]
    return [item for item in found if item[0] > MIN_PROBABILITY]


def counters_of(process: Process, part: int) -> list[int]:
    """Return the numbers of the counters of failed attempts that can differ between the states of a part of
    the network.

    Each counter counts the Fails of one action, or of several actions that share their attempts.

    Args:
        process: the network.
        part: number of the part, which is a strongly connected component.
    """
    network, names = process.network, process.parts[part]
    found = dict.fromkeys(action.counter for name in names for action in process.out[name])
    for counter, shared in network.shared.items():
        if len(shared) > 1 and len({process.part[item.source] for item in shared} - {part}) > 1:
            found[counter] = None
    return [counter for counter in found if process.after.matters(names[0], counter)]
