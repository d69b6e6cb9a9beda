"""The absorbing Markov chain of the coordinator's decisions in a part of a network."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from handcart.robotics.numerics.arrays import FloatArray, IntArray

from .chain_rows import ChainEnd, ChainLinks, ChainRows
from .ends import AT_GOAL, Ends
from .few_collections import few_collections
from .linear_solver import LinearSolver
from .moments import Moments
from .policy import Chances as Chances
from .policy import Policy
from .rule_flow import FlowResult
from .step_maker import State


@dataclass(frozen=True)
class Chain:
    """Probabilities of the ends of runs through a part of a network, and how often the runs start each
    action.
    """

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
        """Return the chain with its ends' probabilities, and the average number of starts of each action, as
        computed by a `RuleFlow`.

        `RuleFlow` follows runs through more states than the chain has, so that its figures are more accurate.
        """
        starts = tuple(map(float, flow.starts))
        return replace(self, ends=flow.ends, starts=starts, ended=flow.ended, skips=flow.skips)


@few_collections()
def policy_chain(policy: Policy, chances: Chances) -> Chain:
    """Return how runs that follow a policy end, from the exact solution of an absorbing Markov chain.

    The result also has the average number of starts of each action, and the derivatives of P(goal). The
    method is that of Kemeny and Snell, Finite Markov Chains (1960), chapter 3. A transient state is an action
    that is about to start, and Q holds the transitions among these states. If chance leads no run in circles,
    a state's successors have smaller numbers. I - Q is then triangular, and the needed parts of its inverse
    follow from a few sparse solutions.
    """
    count = len(policy.network.actions)
    rows = ChainRows(policy, chances)
    if policy.start not in policy.steps:
        nowhere = np.zeros((len(policy.network.situations), len(ChainEnd)))
        return Chain(AT_GOAL, (0.0,) * count, (0.0,) * count, rows, nowhere, 0.0)
    return _Solution(rows, policy).chain(count)


def values_of_states(policy: Policy, chances: Chances) -> dict[State, tuple[float, float]]:
    """Return the expected result of a run from each state in which the policy decides.

    Returns:
        For each state: probability that the run reaches the goal and leaves nothing undone, and expected cost
            in [s].
    """
    values = _Solution(ChainRows(policy, chances), policy).values()
    return dict(zip(policy.steps, values, strict=True))


class _Solution:
    """Solution of a chain's equations."""

    def __init__(self, rows: ChainRows, policy: Policy) -> None:
        self._rows, self._size, circles = rows, len(rows.action), policy.circles
        self._situations = len(policy.network.situations)
        links = rows.succeeds.joined(rows.fails)
        self._lost = _endless(rows, links.joined(rows.skips)) if circles else np.zeros(0, np.int64)
        """(n,) rows from which no end is ever reached."""
        keep = links.without(self._lost) if len(self._lost) else links
        self._plain = LinearSolver(self._size, keep, circles)
        """Without skips: runs that leave nothing undone."""
        self._every = self._plain
        if len(rows.skips.row):
            every = keep.joined(rows.skips.without(self._lost))
            self._every = LinearSolver(self._size, every, circles)

    def chain(self, count: int) -> Chain:
        rows = self._rows
        ends = self._moments(self._every, self._into(skips=True))
        complete = ends[:, :1]
        if rows.has_skips:
            complete = self._moments(self._plain, self._into(skips=False)[:, :1])
        at = [Moments(*map(float, swapax[rows.start])) for swapax in (complete[:, 0], *ends.swapaxes(0, 1))]
        skipped = Moments(*(max(0.0, a - b) for a, b in zip(at[1], at[0], strict=True)))
        known = Ends(at[0], skipped if rows.has_skips else Moments(0.0), at[2], at[3], at[4])
        begins = np.zeros(self._size)
        begins[rows.start] = 1.0
        visits = self._every.solve(begins, True)
        starts = self._by_action(count, visits)
        slopes = self._by_action(count, self._plain.solve(begins, True) * self._gain(complete[:, 0, 0]))
        skips = np.concatenate((rows.skips.row, rows.skipped_to_goal))
        return Chain(known, starts, slopes, rows, self._ended(visits), float(visits[skips].sum()))

    def values(self) -> list[tuple[float, float]]:
        """Return for each row the probability of the goal without skips, and the expected cost in [s]."""
        cost = self._rows.cost[:, None]
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
        actions = self._rows.action
        acts = actions >= 0
        return tuple(np.bincount(actions[acts], values[acts], count).tolist())

    def _into(self, skips: bool) -> FloatArray:
        """Return the probabilities (rows, ends) that a run ends right after each row; `skips` adds skips that
        reach the goal.
        """
        into, ends = np.zeros((self._size, len(ChainEnd))), self._rows.ends
        np.add.at(into, (ends.row, ends.end), ends.p)
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
        cost = self._rows.cost[:, None]
        p = solver.solve(into)
        first = solver.solve(cost * p)
        # With C' what is left after this step: (c + C')² = 2 c (c + C') - c² + C'².
        second = solver.solve(2.0 * cost * first - cost**2 * p)
        return np.stack((p, first, second), axis=-1)

    def _gain(self, goal: FloatArray) -> FloatArray:
        """Return by how much P(goal) after a Success exceeds that after a Fail, (rows,); `goal` (rows,) is
        P(goal) from each row.
        """
        size, links, ends = self._size, self._rows.succeeds, self._rows.ends
        known = ((ends.end == ChainEnd.GOAL) | (ends.end == ChainEnd.UNKNOWN)) & ~ends.failed
        row, p = np.append(links.row, ends.row[known]), np.append(links.p, ends.p[known])
        value = np.append(goal[links.to], ends.end[known] == ChainEnd.GOAL)
        success = np.bincount(row, p, size)
        return np.bincount(row, p * value, size) / np.maximum(success, 1e-300) - self._after_fail(goal)

    def _after_fail(self, goal: FloatArray) -> FloatArray:
        """Return P(goal) after a Fail of each row, (rows,); `goal` (rows,) is P(goal) from each row.

        It is the mean over the causes of the Fail, unweighted if all have p = 0.
        """
        size, links, ends = self._size, self._rows.fails, self._rows.ends
        row = np.append(links.row, ends.row[ends.failed])
        p = np.append(links.p, ends.p[ends.failed])
        value = np.append(goal[links.to], ends.end[ends.failed] == ChainEnd.GOAL)
        never = np.bincount(row, p, size)[row] <= 0.0
        weight = np.where(never, 1.0, p)
        total = np.bincount(row, weight, size)
        return np.asarray(np.bincount(row, value * (weight / total[row]), size))


def _endless(rows: ChainRows, links: ChainLinks) -> IntArray:
    """Return the rows (n,) from which no end is ever reached: the run then ends at its bound."""
    from scipy.sparse.csgraph import breadth_first_order  # late: most networks have no circles

    size, happens, ends = len(rows.action), links.p > 0.0, rows.ends
    last = np.concatenate((ends.row[ends.p > 0.0], rows.skipped_to_goal))
    source = np.append(links.to[happens], np.full(len(last), size))
    before = csr_array((np.ones(len(source)), (source, np.append(links.row[happens], last))), [size + 1] * 2)
    reached = breadth_first_order(before, size, return_predecessors=False)
    return np.setdiff1d(np.arange(size), reached)
