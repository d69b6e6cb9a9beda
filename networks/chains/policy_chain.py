"""The absorbing Markov chain of the coordinator's decisions in a part of a network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, eye_array

from .chance import Chance
from .ends import AT_GOAL, Ends
from .moments import Moments
from .policy import Policy, State

Chances = Sequence[Chance | None]
"""Outcome probabilities of each action by its number; None for a skip, which always succeeds."""
Floats = NDArray[np.float64]
DENSE_MAX_ROWS = 100
"""Rows up to which a full matrix is faster than a sparse one."""


@dataclass(frozen=True)
class Chain:
    """Results of a part of a network, over the runs that enter it."""

    ends: Ends
    starts: tuple[float, ...]
    """Average number of starts of each action."""
    slopes: tuple[float, ...]
    """Derivative of P(goal) by each action's probability of Success, with the Fails becoming fewer."""


def policy_chain(policy: Policy, chances: Chances) -> Chain:
    """The exact figures, by Kemeny and Snell, Finite Markov Chains (1960), chapter 3.

    A transient state is an action of a plan, about to start. They are numbered so that what follows comes
    before: I - Q is triangular, and what is asked of its inverse comes of a few sparse solutions.
    """
    count = len(policy.network.actions)
    if policy.start not in policy.steps:
        return Chain(AT_GOAL, (0.0,) * count, (0.0,) * count)
    return _Table(policy, chances).chain(count)


class _Sparse:
    """Solver for large chains, by a sparse factorization of I - Q."""

    def __init__(self, follows: Any) -> None:
        from scipy.sparse.linalg import splu  # late: most networks are small

        # Triangular, with a diagonal of ones: neither reordering nor pivots, nothing fills in.
        whole = (eye_array(follows.shape[0]) - follows).tocsc()
        self._factors = splu(whole, permc_spec="NATURAL", diag_pivot_thresh=0.0)

    def solve(self, right: Floats, transposed: bool = False) -> Floats:
        solution: Floats = self._factors.solve(right, "T" if transposed else "N")
        return solution


class _Dense:
    """Solver for small chains, by a dense inverse."""

    def __init__(self, follows: Any) -> None:
        self._inverse = np.linalg.inv(np.eye(follows.shape[0]) - follows.toarray())

    def solve(self, right: Floats, transposed: bool = False) -> Floats:
        solution: Floats = (self._inverse.T if transposed else self._inverse) @ right
        return solution


_Solver = _Sparse | _Dense


class _Table:
    """A row for each action of each plan; rows of states in which nothing is left to try have no action."""

    def __init__(self, policy: Policy, chances: Chances) -> None:
        first: dict[State, int] = {}
        self._action: list[int] = []
        self._succeeds: list[tuple[int, int, float]] = []  # row, row that follows, probability
        self._fails: list[tuple[int, int, float]] = []
        self._skips: list[tuple[int, int, float]] = []
        self._ends: list[tuple[int, int, float]] = []  # row, 0 goal, 1 goal by a Fail, 2 no way, 3 giving up
        self._cost: list[float] = []
        self._goal = policy.network.goal
        for state, step in policy.steps.items():
            if not step.plan:
                self._ends.append((len(self._action), 2, 1.0))
                self._row(-1, 0.0)
            for number in range(len(step.plan) - 1, -1, -1):
                self._add(policy, chances, state, number, first)
            first[state] = len(self._action) - 1
        self._start = first[policy.start]

    def _row(self, action: int, cost: float) -> None:
        self._action.append(action)
        self._cost.append(cost)

    def _add(
        self, policy: Policy, chances: Chances, state: State, number: int, first: Mapping[State, int]
    ) -> None:
        step, here = policy.steps[state], len(self._action)
        action, failed = step.plan[number], step.after_fail[number]
        chance, last = chances[action.index], number == len(step.plan) - 1
        if failed is None or chance is None:
            self._row(-1, 0.0)
            self._skips.append((here, -1 if last else here - 1, 1.0))
            return
        self._row(action.index, action.cost_s)
        if last:
            self._ends.append((here, 0, chance.success))
        else:
            self._succeeds.append((here, here - 1, chance.success))
        if failed.situation == self._goal:
            self._ends.append((here, 1, chance.fail))
        else:
            self._fails.append((here, first[failed], chance.fail))
        self._ends.append((here, 3, chance.give_up))

    def chain(self, count: int) -> Chain:
        size = len(self._action)
        on_skips = [each for each in self._skips if each[1] >= 0]
        whole, every = self._solver([]), self._solver(on_skips)
        into = np.zeros((size, 4))
        for row, end, p in self._ends:
            into[row, end] += p
        goal = into[:, :1] + into[:, 1:2]
        reached = goal.copy()
        reached[[row for row, to, _ in self._skips if to < 0]] += 1.0
        ends = np.hstack((reached, into[:, 2:]))
        complete, anyway = self._moments(whole, goal), self._moments(every, ends)
        at = [Moments(*map(float, each[self._start])) for each in (complete[:, 0], *anyway.swapaxes(0, 1))]
        skipped = Moments(*(max(0.0, a - b) for a, b in zip(at[1], at[0], strict=True)))
        slopes, starts = np.zeros(count), np.zeros(count)
        actions = np.array(self._action)
        acts = actions >= 0
        begins = np.zeros(size)
        begins[self._start] = 1.0
        np.add.at(starts, actions[acts], every.solve(begins, True)[acts])
        gain = whole.solve(begins, True) * self._gain(complete[:, 0, 0])
        np.add.at(slopes, actions[acts], gain[acts])
        known = Ends(at[0], skipped if self._skips else Moments(0.0), at[2], at[3])
        return Chain(known, tuple(map(float, starts)), tuple(map(float, slopes)))

    def _solver(self, more: Sequence[tuple[int, int, float]]) -> _Solver:
        size = len(self._action)
        rows, to, p = zip(*(*self._succeeds, *self._fails, *more, (0, 0, 0.0)), strict=True)
        follows = csc_array((p, (rows, to)), shape=(size, size))
        return _Dense(follows) if size <= DENSE_MAX_ROWS else _Sparse(follows)

    def _moments(self, solver: _Solver, into: Floats) -> Floats:
        """Return moments of the cost by rows and ends: probability, E[C; end], E[C²; end]."""
        cost = np.array(self._cost)[:, None]
        p = solver.solve(into)
        first = solver.solve(cost * p)
        # With C' what is left after this step: (c + C')² = 2 c (c + C') - c² + C'².
        second = solver.solve(2.0 * cost * first - cost**2 * p)
        return np.stack((p, first, second), axis=-1)

    def _gain(self, goal: Floats) -> Floats:
        """Return for each row by how much P(goal) after a Success exceeds that after a Fail."""
        gain = np.zeros(len(goal))
        for row, to, _ in self._succeeds:
            gain[row] += goal[to]
        for row, to, _ in self._fails:
            gain[row] -= goal[to]
        for row, end, _ in self._ends:
            gain[row] += {0: 1.0, 1: -1.0}.get(end, 0.0)
        return gain
