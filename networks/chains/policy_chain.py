"""The absorbing Markov chain of the coordinator's decisions in a part of a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

from .chain_rows import ChainEnd, ChainLink, ChainRows
from .ends import AT_GOAL, Ends
from .linear_solver import LinearSolver
from .moments import Moments
from .policy import Chances as Chances
from .policy import Policy
from .rule_flow import FlowResult
from .step_maker import State


@dataclass(frozen=True)
class Chain:
    """Probabilities, starts and costs of the runs through a part of a network."""

    ends: Ends
    starts: tuple[float, ...]
    """Average number of starts of each action."""
    slopes: tuple[float, ...]
    """Derivative of P(goal) by each action's probability of Success, whose Fails become rarer by as much."""
    rows: ChainRows
    ended: FloatArray
    """(situations, ends) probability that a run ends in each situation, with a column for each `ChainEnd`."""
    skips: float
    """Average number of skips."""

    def with_flow(self, flow: FlowResult) -> Chain:
        """Return the chain with the ends of a flow that has followed more states."""
        starts = tuple(map(float, flow.starts))
        return replace(self, ends=flow.ends, starts=starts, ended=flow.ended, skips=flow.skips)


def policy_chain(policy: Policy, chances: Chances) -> Chain:
    """Return the exact figures, by Kemeny and Snell, Finite Markov Chains (1960), chapter 3.

    A transient state is an action that is about to start. States are numbered so that what follows comes
    before, as long as chance leads no run in circles: I - Q is triangular, and the needed parts of its
    inverse follow from a few sparse solutions.
    """
    count = len(policy.network.actions)
    rows = ChainRows(policy, chances)
    if policy.start not in policy.steps:
        nowhere = np.zeros((len(policy.network.situations), len(ChainEnd)))
        return Chain(AT_GOAL, (0.0,) * count, (0.0,) * count, rows, nowhere, 0.0)
    return _Solution(rows, policy).chain(count)


def values_of_states(policy: Policy, chances: Chances) -> dict[State, tuple[float, float]]:
    """Return the expected result of a run from each state of a policy.

    Returns:
        By state: probability of the goal with nothing left undone, and expected cost in [s].
    """
    values = _Solution(ChainRows(policy, chances), policy).values()
    return dict(zip(policy.steps, values, strict=True))


class _Solution:
    """Solution of a chain's equations."""

    def __init__(self, rows: ChainRows, policy: Policy) -> None:
        self._rows, self._size, circles = rows, len(rows.action), policy.circles
        self._situations = len(policy.network.situations)
        links = [*rows.succeeds, *rows.fails]
        lost = _endless(rows, [*links, *rows.skips]) if circles else set[int]()
        self._lost = sorted(lost)
        keep = [link for link in links if link.row not in lost]
        skips = [link for link in rows.skips if link.row not in lost]
        self._plain = LinearSolver(self._size, keep, circles)
        """Without skips: runs that leave nothing undone."""
        self._every = LinearSolver(self._size, [*keep, *skips], circles) if rows.skips else self._plain

    def chain(self, count: int) -> Chain:
        rows = self._rows
        ends = self._moments(self._every, self._into(skips=True))
        complete = self._moments(self._plain, self._into(skips=False)[:, :1])
        at = [Moments(*map(float, swapax[rows.start])) for swapax in (complete[:, 0], *ends.swapaxes(0, 1))]
        skipped = Moments(*(max(0.0, a - b) for a, b in zip(at[1], at[0], strict=True)))
        has_skips = bool(rows.skips or rows.skipped_to_goal)
        known = Ends(at[0], skipped if has_skips else Moments(0.0), at[2], at[3], at[4])
        begins = np.zeros(self._size)
        begins[rows.start] = 1.0
        visits = self._every.solve(begins, True)
        starts = self._by_action(count, visits)
        slopes = self._by_action(count, self._plain.solve(begins, True) * self._gain(complete[:, 0, 0]))
        skips = [*(link.row for link in rows.skips), *rows.skipped_to_goal]
        return Chain(known, starts, slopes, rows, self._ended(visits), float(visits[skips].sum()))

    def values(self) -> list[tuple[float, float]]:
        """Return for each row the probability of the goal without skips, and the expected cost in [s]."""
        cost = np.array(self._rows.cost)[:, None]
        complete = self._plain.solve(self._into(skips=False)[:, :1])
        first = self._every.solve(cost * self._every.solve(self._into(skips=True)))
        return list(zip(map(float, complete[:, 0]), map(float, first.sum(axis=1)), strict=True))

    def _ended(self, visits: FloatArray) -> FloatArray:
        """Return the probabilities (situations, ends) that a run ends in each situation, by the visits
        (rows,) to each row.
        """
        found = np.zeros((self._situations, len(ChainEnd)))
        np.add.at(found, self._rows.places, self._into(skips=True) * visits[:, None])
        return found

    def _by_action(self, count: int, values: FloatArray) -> tuple[float, ...]:
        found, actions = np.zeros(count), np.array(self._rows.action)
        acts = actions >= 0
        np.add.at(found, actions[acts], values[acts])
        return tuple(map(float, found))

    def _into(self, skips: bool) -> FloatArray:
        """Return the probabilities (rows, ends) that a run ends right after each row; `skips` adds skips that
        reach the goal.
        """
        into = np.zeros((self._size, len(ChainEnd)))
        for row, end, p, _ in self._rows.ends:
            into[row, end] += p
        into[self._lost] = 0.0
        into[self._lost, ChainEnd.NO_WAY] = 1.0
        if skips:
            into[self._rows.skipped_to_goal, ChainEnd.GOAL] += 1.0
        return into

    def _moments(self, solver: LinearSolver, into: FloatArray) -> FloatArray:
        """Return moments (rows, ends, 3) of the cost C from each row on: probability, E[C; end] and E[C²;
        end].

        Args:
            solver: solver of the chain's equations.
            into: (rows, ends) probabilities that a run ends right after each row.
        """
        cost = np.array(self._rows.cost)[:, None]
        p = solver.solve(into)
        first = solver.solve(cost * p)
        # With C' what is left after this step: (c + C')² = 2 c (c + C') - c² + C'².
        second = solver.solve(2.0 * cost * first - cost**2 * p)
        return np.stack((p, first, second), axis=-1)

    def _gain(self, goal: FloatArray) -> FloatArray:
        """Return by how much P(goal) after a Success exceeds that after a Fail, (rows,); `goal` (rows,) is
        P(goal) from each row.
        """
        gain = np.zeros(self._size)
        success = np.zeros(self._size)
        for row, to, p in self._rows.succeeds:
            gain[row] += p * goal[to]
            success[row] += p
        for row, end, p, failed in self._rows.ends:
            if end in (ChainEnd.GOAL, ChainEnd.UNKNOWN) and not failed:
                gain[row] += p * (end == ChainEnd.GOAL)
                success[row] += p
        gain /= np.maximum(success, 1e-300)
        return gain - self._after_fail(goal)

    def _after_fail(self, goal: FloatArray) -> FloatArray:
        """Return P(goal) after a Fail of each row, (rows,); `goal` (rows,) is P(goal) from each row.

        It is the mean over the causes of the Fail, unweighted if all have p = 0.
        """
        links = [(row, p, float(goal[to])) for row, to, p in self._rows.fails]
        links += [(row, p, float(end == ChainEnd.GOAL)) for row, end, p, failed in self._rows.ends if failed]
        total, count, mean = np.zeros(self._size), np.zeros(self._size), np.zeros(self._size)
        for row, p, _ in links:
            total[row] += p
            count[row] += 1
        for row, p, value in links:
            mean[row] += value * (p / total[row] if total[row] > 0.0 else 1.0 / count[row])
        return mean


def _endless(rows: ChainRows, links: Sequence[ChainLink]) -> set[int]:
    """Return the rows from which no end is ever reached: the run then ends at its bound."""
    before: dict[int, list[int]] = {}
    for row, to, p in links:
        if p > 0.0:
            before.setdefault(to, []).append(row)
    ahead = [row for row, _, p, _ in rows.ends if p > 0.0] + rows.skipped_to_goal
    reached = set(ahead)
    while ahead:
        for row in before.get(ahead.pop(), ()):
            if row not in reached:
                reached.add(row)
                ahead.append(row)
    return set(range(len(rows.action))) - reached
