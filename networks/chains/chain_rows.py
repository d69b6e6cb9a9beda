"""Rows of an absorbing Markov chain: the states of a policy, and what follows them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from handcart.networks.graph.network import Action
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

from .chance import Chance
from .policy import Chances, Policy, fail_shares, success_shares
from .step_maker import State, Step


class ChainEnd(IntEnum):
    """Kind of end of a run: goal, no action left, GiveUp, or unknown because a state was not examined.

    The value is the kind's column in arrays of ends, such as `Chain.ended`.
    """

    GOAL = 0
    NO_WAY = 1
    GIVE_UP = 2
    UNKNOWN = 3
    """The run comes to a state that was not expanded."""


class ChainLinks(NamedTuple):
    """Transitions between the states (rows) of a Markov chain, as arrays (n,): the row before, the row after,
    and the probability.
    """

    row: IntArray
    to: IntArray
    p: FloatArray

    def without(self, rows: IntArray) -> ChainLinks:
        """Return the transitions except those that begin in given rows of the chain, by the rows' numbers
        (k,).
        """
        keep = ~np.isin(self.row, rows)
        return ChainLinks(self.row[keep], self.to[keep], self.p[keep])

    def joined(self, *others: ChainLinks) -> ChainLinks:
        """Return one table with these transitions between states, followed by those of `others`."""
        return ChainLinks(*(np.concatenate(columns) for columns in zip(self, *others, strict=True)))


class ChainEnds(NamedTuple):
    """Transitions from states of a Markov chain to ends of a run, such as the goal, as arrays (n,) with the
    state's row, the end and the probability of each transition.
    """

    row: IntArray
    end: IntArray
    """Number of the end, as in `ChainEnd`."""
    p: FloatArray
    failed: BoolArray
    """True if a Fail leads there."""


class _Shares(NamedTuple):
    """Probabilities of what follows an action."""

    succeeded: Sequence[float]
    failed: Sequence[float]
    give_up: float


class ChainRows:
    """Transitions and costs of the Markov chain of a policy, with a row for each state of the policy."""

    def __init__(self, policy: Policy, chances: Chances) -> None:
        """Assign numbers to the states, and collect their successors."""
        self._goal, self._chances = policy.network.goal, chances
        self._shares: dict[int, _Shares] = {}
        self._number = {state: number for number, state in enumerate(policy.steps)}
        # Columns one after the other: thousands of small objects would cost more than the equations.
        self._succeeds, self._fails, self._skips = list[float](), list[float](), list[float]()
        self._ends, self._skipped = list[float](), list[int]()
        for row, step in enumerate(policy.steps.values()):
            self._add(row, step)
        acts = [step.action for step in policy.steps.values()]
        acts = [action if action and action.binding is not None else None for action in acts]
        place = {name: number for number, name in enumerate(policy.network.situations)}
        self.action = np.array([-1 if action is None else action.index for action in acts], np.int64)
        """(rows,) the action that starts in each row; -1 for none and for skips."""
        self.cost = np.array([0.0 if action is None else action.cost_s for action in acts])
        """(rows,) its cost in [s]; 0 for none and for skips."""
        self.places = np.array([place[state.situation] for state in policy.steps], np.int64)
        """(rows,) number of each row's situation in the network."""
        self.succeeds, self.fails = _links(self._succeeds), _links(self._fails)
        self.skips = _links(self._skips)
        self.ends = _ends(self._ends)
        self.skipped_to_goal = np.array(self._skipped, np.int64)
        """(n,) rows whose skip leads to the goal."""
        self.start = self._number.get(policy.start, -1)

    @property
    def has_skips(self) -> bool:
        """True if a run may leave out actions for an element of a list over which the task repeats them."""
        return bool(len(self.skips.row) or len(self.skipped_to_goal))

    def _add(self, row: int, step: Step) -> None:
        action = step.action
        if action is None:
            self._ends += row, ChainEnd.GIVE_UP if step.person else ChainEnd.NO_WAY, 1.0, False
            return
        if action.binding is None:
            self._skip(row, step)
            return
        shares = self._shares.get(action.index) or self._shares_of(action)
        for p, state in zip(shares.succeeded, step.succeeded, strict=True):
            self._lead(row, state, p, self._succeeds, False)
        self._lead(row, step.failed, shares.failed[0], self._fails, True)
        for p, state in zip(shares.failed[1:], step.failed_by, strict=True):
            self._lead(row, state, p, self._fails, True)
        if shares.give_up:
            self._ends += row, ChainEnd.GIVE_UP, shares.give_up, False

    def _shares_of(self, action: Action) -> _Shares:
        chance = self._chances[action.index] or Chance(1.0)
        succeeded = [chance.success * share for share in success_shares(action, chance)]
        failed = [chance.fail * share for share in fail_shares(action, chance)]
        found = self._shares[action.index] = _Shares(succeeded, failed, chance.give_up)
        return found

    def _lead(self, row: int, state: State | None, p: float, links: list[float], failed: bool) -> None:
        if state is None:
            return
        to = self._number.get(state)
        if to is not None:
            links += row, to, p
        else:
            end = ChainEnd.GOAL if state.situation == self._goal else ChainEnd.UNKNOWN
            self._ends += row, end, p, failed

    def _skip(self, row: int, step: Step) -> None:
        state = step.succeeded[0]
        assert state is not None
        if state.situation == self._goal:
            self._skipped.append(row)
        else:
            self._lead(row, state, 1.0, self._skips, False)


def _links(numbers: Sequence[float]) -> ChainLinks:
    row, to, p = np.array(numbers, np.float64).reshape(-1, 3).T
    return ChainLinks(row.astype(np.int64), to.astype(np.int64), p)


def _ends(numbers: Sequence[float]) -> ChainEnds:
    row, end, p, failed = np.array(numbers, np.float64).reshape(-1, 4).T
    return ChainEnds(row.astype(np.int64), end.astype(np.int64), p, failed > 0.0)
