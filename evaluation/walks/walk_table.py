"""What the coordinator does in a network, as columns of numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import State, StepMaker
from handcart.networks.graph.network import ActionNetwork

GOAL, NO_WAY = -1, -2
"""In place of a moment's number: where a walk ends."""

Numbers = NDArray[np.int32]


class Columns(NamedTuple):
    """Of each moment at which an action is about to start, by its number."""

    action: Numbers
    fails: Numbers
    """How often it has failed."""
    next: Numbers
    """The moment after its Success; or `GOAL`."""
    after_fail: Numbers
    """The state after its Fail, by that one's number."""
    for_good: Numbers
    """The same after a Fail for good."""
    skip: NDArray[np.bool_]
    """Whether it only leaves an element of a repeat undone, which can't fail."""


class WalkTable:
    """Decisions, each worked out when the first walk comes to it: most states are never reached."""

    def __init__(self, network: ActionNetwork) -> None:
        """Of a network; nothing is worked out but the beginning."""
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
        """Of all moments that are known by now; a later call may know more."""
        if self._columns is None:
            columns = np.array(self._rows, dtype=np.int32).reshape(-1, 6).T
            action, fails, following, after_fail, for_good, skip = columns
            self._columns = Columns(action, fails, following, after_fail, for_good, skip.astype(bool))
        return self._columns

    def first(self, states: Numbers) -> Numbers:
        """The first moment of each state's plan (n,); `GOAL` there, `NO_WAY` where nothing is left to try."""
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
        self._first[number] = len(self._rows) if step.plan else NO_WAY
        fails = dict(state.fails)
        fates = zip(step.plan, step.after_fail, step.for_good, strict=True)
        for place, (action, once, good) in enumerate(fates, start=1):
            following = GOAL if place == len(step.plan) else len(self._rows) + 1
            failed, skip = fails.get(action.index, 0), action.binding is None
            after = self._after(once), self._after(good)
            self._rows.append((action.index, failed, following, *after, skip))
        self._columns = None

    def _after(self, state: State | None) -> int:
        return -1 if state is None else self._state(state)

    def _state(self, state: State) -> int:
        number = self._number.setdefault(state, len(self._states))
        if number == len(self._states):
            self._states.append(state)
            self._first.append(None)
        return number
