"""Decisions of the coordinator in a network, as columns of numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.files.errors import InputError
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.step_maker import State, StepMaker
from handcart.networks.graph.network import ActionNetwork
from handcart.robotics.numerics.arrays import BoolArray, Int32Array

GOAL, NO_WAY = -1, -2
"""Values instead of a state's number, at the end of a walk."""


class NotWalked(InputError):
    """Error for a network of actions with a feature that random walks do not support."""


class Columns(NamedTuple):
    """Table of a coordinator's states, with the planned action and the next states of each, by columns.

    The arrays are (states,). The row of a state is undefined until a walk has reached that state.
    """

    action: Int32Array
    fails: Int32Array
    """Number of earlier Fails of the action that each state plans."""
    next: Int32Array
    """Number of the next state after a Success that leads to the action's target."""
    after_fail: Int32Array
    """Number of the next state after a Fail."""
    for_good: Int32Array
    """Number of the next state after a permanent Fail."""
    skip: BoolArray
    """True if the action only skips an element of a repeat, which cannot fail."""


class WalkTable:
    """Table of the coordinator's decisions in each state of a network, for random walks without a robot.

    A decision is computed when a walk first reaches the state in which it is made.

    Raises:
        NotWalked: a Success, or a Fail by its cause, may lead to several situations.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """Create the table of a network; only the decision at the start is computed."""
        several = next((a for a in network.actions if a.others or a.fail_endings), None)
        if several is not None:
            words = f"{several} differs by result or cause; allowed with --level network: one situation"
            raise NotWalked(words)
        if network.policy != "rule":
            raise NotWalked(f"the policy is {network.policy}; allowed with --level network: rule")
        self._network = network
        self._maker = StepMaker(network, True, Effort(math.inf))
        self._states: list[State] = []
        self._number: dict[State, int] = {}
        self._rows: list[tuple[int, int, int, int, int, bool]] = []
        self._first: list[int | None] = []
        self._columns: Columns | None = None
        start = self._state(State(network.start, ()))
        self.start = self.first(np.array([start], dtype=np.int32))[0]

    def columns(self) -> Columns:
        """Return the decisions in all states that walks have reached so far, as an array for each column.

        A later call may return more rows.
        """
        if self._columns is None:
            columns = np.array(self._rows, dtype=np.int32).reshape(-1, 6).T
            action, fails, following, after_fail, for_good, skip = columns
            self._columns = Columns(action, fails, following, after_fail, for_good, skip.astype(bool))
        return self._columns

    def first(self, states: Int32Array) -> Int32Array:
        """Plan the next action in each of n states of the table.

        Args:
            states: (n,) numbers of states in the table.

        Returns:
            (n,) for each state the row of its planned action, which is the state's number; `GOAL` for a state
            at the goal, `NO_WAY` for a state without a route to the goal.
        """
        for number in set(states.tolist()):
            if self._first[number] is None:
                self._work_out(number)
        return np.array([self._first[number] for number in states.tolist()], dtype=np.int32)

    def _work_out(self, number: int) -> None:
        state = self._states[number]
        if state.situation == self._network.goal:
            self._first[number] = GOAL
            return
        step = self._maker.step(state)
        action = step.action
        if action is None:
            self._first[number] = NO_WAY
            return
        self._first[number] = number
        failed = action.allowance.fails(dict(state.fails).get(action.counter, 0))
        succeeded, after_fail, for_good = map(self._after, (step.succeeded[0], step.failed, step.for_good))
        self._rows[number] = action.index, failed, succeeded, after_fail, for_good, action.binding is None
        self._columns = None

    def _after(self, state: State | None) -> int:
        return -1 if state is None else self._state(state)

    def _state(self, state: State) -> int:
        number = self._number.setdefault(state, len(self._states))
        if number == len(self._states):
            self._states.append(state)
            self._rows.append((-1, 0, -1, -1, -1, False))
            self._first.append(None)
            self._columns = None
        return number
