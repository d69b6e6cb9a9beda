"""Rows of an absorbing Markov chain: the states of a policy, and what follows them."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from .chance import Chance
from .policy import Chances, Policy, fail_shares, success_shares
from .step_maker import State, Step


class ChainEnd(IntEnum):
    """Kind of end of a run, as a column number."""

    GOAL = 0
    NO_WAY = 1
    GIVE_UP = 2
    UNKNOWN = 3
    """The run comes to a state that was not expanded."""


class ChainLink(NamedTuple):
    """Transition from one row of a chain to another."""

    row: int
    to: int
    p: float


class ChainRows:
    """Rows of a chain, in the order of the policy's states."""

    def __init__(self, policy: Policy, chances: Chances) -> None:
        """Assign numbers to the states, and collect their successors."""
        self.action: list[int] = []
        """The action that starts in each row; -1 for none and for skips."""
        self.cost: list[float] = []
        """Its cost in [s]; 0 for none and for skips."""
        self.places: list[int] = []
        """Number of each row's situation in the network."""
        self.succeeds: list[ChainLink] = []
        self.fails: list[ChainLink] = []
        self.skips: list[ChainLink] = []
        self.ends: list[tuple[int, ChainEnd, float, bool]] = []
        """Row, end, probability, and whether a Fail leads there."""
        self.skipped_to_goal: list[int] = []
        """Rows whose skip leads to the goal."""
        self._policy, self._chances = policy, chances
        self._number = {state: number for number, state in enumerate(policy.steps)}
        place = {name: number for number, name in enumerate(policy.network.situations)}
        for row, (state, step) in enumerate(policy.steps.items()):
            self.places.append(place[state.situation])
            self._add(row, step)
        self.start = self._number.get(policy.start, -1)

    def _add(self, row: int, step: Step) -> None:
        action = step.action
        if action is None:
            self._row(-1, 0.0)
            self.ends.append((row, ChainEnd.GIVE_UP if step.person else ChainEnd.NO_WAY, 1.0, False))
            return
        if action.binding is None:
            self._row(-1, 0.0)
            self._skip(row, step)
            return
        chance = self._chances[action.index] or Chance(1.0)
        self._row(action.index, action.cost_s)
        for share, state in zip(success_shares(action, chance), step.succeeded, strict=True):
            self._lead(row, state, chance.success * share, self.succeeds, False)
        for share, state in zip(fail_shares(action, chance), step.all_failed, strict=True):
            self._lead(row, state, chance.fail * share, self.fails, True)
        if chance.give_up:
            self.ends.append((row, ChainEnd.GIVE_UP, chance.give_up, False))

    def _row(self, action: int, cost: float) -> None:
        self.action.append(action)
        self.cost.append(cost)

    def _lead(self, row: int, state: State | None, p: float, links: list[ChainLink], failed: bool) -> None:
        if state is None:
            return
        if self._policy.goal(state):
            self.ends.append((row, ChainEnd.GOAL, p, failed))
        elif state in self._number:
            links.append(ChainLink(row, self._number[state], p))
        else:
            self.ends.append((row, ChainEnd.UNKNOWN, p, failed))

    def _skip(self, row: int, step: Step) -> None:
        state = step.succeeded[0]
        assert state is not None
        if self._policy.goal(state):
            self.skipped_to_goal.append(row)
        elif state in self._number:
            self.skips.append(ChainLink(row, self._number[state], 1.0))
        else:
            self.ends.append((row, ChainEnd.UNKNOWN, 1.0, False))
