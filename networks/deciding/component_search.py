"""Search for the least expected cost from states of one strongly connected component."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array, eye_array

from handcart.networks.chains.effort import Effort
from handcart.networks.chains.step_maker import State
from handcart.networks.graph.network import Action
from handcart.robotics.numerics.arrays import FloatArray, IntArray

from .process import Process
from .situation_values import SituationValues
from .state_rows import StateRows
from .state_table import STOP_CHOICE, StateTable

LOW_SWEEPS, HIGH_SWEEPS = 8, 10
"""Sweeps over all states for each round of the search."""
EXPANDED_SHARE = 0.9
"""Share of the gap whose states are expanded in a round; below 1 there are more rounds but fewer states."""
MIN_EXPANDED = 200
"""Maximum number of states that a round expands while the search has expanded fewer; later as many as it
has.
"""
ROUND_GROWTH = 0.25
"""Share by which a round expands more states, level by level, while the policy leads on to new ones."""
MAX_ROUND_LEVELS = 3
"""Maximum number of levels of states that a round expands, one behind the other."""
SLACK_SHARE = 0.05
"""Share of the gap by which the solution of a policy may miss the optimum and still bound it."""
ROUND_STEPS, TRANSITION_STEPS, STATE_STEPS = 300.0, 0.012, 1.5
"""Effort of a round, of each transition in it, and of each new state."""
MAX_PROBABILITY = 1.0 - 1e-13
"""Factor of all probabilities, so that a policy that never ends has a solution, too: a very large one."""
MAX_POLICY_STATES = 40_000
"""Maximum number of the policy's states that are reported as known, the likeliest ones."""
Bounds = Callable[[State], tuple[float, float] | None]
"""Function that returns the bounds of a state beyond the component; None if it is not settled."""


class _Solution(NamedTuple):
    """Values and visits of a policy's states, with the bounds of states that were not expanded."""

    states: IntArray
    """(n,) numbers of the expanded states that the policy reaches."""
    low: FloatArray
    high: FloatArray
    visits: FloatArray
    """(states,) expected number of visits of the policy to each state of the table."""


_Decision = tuple[Action | None, float, float]
"""Best action in a state, and the lower and upper bound of its expected cost, in [s]."""


class _Decisions(NamedTuple):
    """Best decision in each state by the upper bounds."""

    options: IntArray
    cost: FloatArray
    likely: dict[int, _Decision]
    """Decisions in the states that the policy visits most, by the states' numbers."""


class ComponentSearch:
    """Search for the best decisions in the states of one strongly connected component.

    Each state has a lower and an upper bound of its expected cost, improved until they are close. Each round
    follows the policy that is best by the lower bounds, and expands its states that contribute most to the
    difference of the bounds (LAO*, Hansen and Zilberstein 2001). The policy's linear equations are solved
    exactly; they are nearly triangular, because a run's Fails only increase.
    """

    def __init__(
        self, process: Process, bounds: SituationValues, part: int, carried: tuple[int, ...] = ()
    ) -> None:
        """Create the search without a state.

        Args:
            process: the network.
            bounds: lower bounds by situation.
            part: number of the component.
            carried: counters of Fails from beyond the component that a run has brought back into it.
        """
        self._rows = StateRows(process, part, carried)
        self._table = StateTable(self._rows, bounds, part)
        self._beyond: dict[int, State] = {}
        """States just beyond the component, by their numbers."""
        self._looked = 0
        self._least_price = float(self._rows.price.min(initial=np.inf))
        self._roots: dict[int, None] = {}
        self._settled: dict[int, None] = {}
        self._decisions: _Decisions | None = None

    def bounds(self, state: State) -> tuple[float, float] | None:
        """Return the lower and upper bound of a state's expected cost, in [s]; None if the search has not met
        the state.
        """
        number = self._table.number(self._rows.key(state))
        return None if number is None else (float(self._table.low[number]), float(self._table.high[number]))

    def settle(self, state: State, gap: float, effort: Effort, beyond: Bounds) -> State | None:
        """Improve the bounds of a state's expected cost until they are close; the state is then settled.

        Args:
            state: the state.
            gap: largest difference of the bounds, relative to the upper bound.
            effort: budget.
            beyond: function that returns the bounds of a settled state outside this component of the network.

        Returns:
            A state outside the component that has to be settled first; None if the bounds are as close as
                asked, or if no further state would bring them closer.

        Raises:
            TooMuch: the budget is spent; the bounds are valid, but not close enough.
        """
        table = self._table
        root = int(table.add(self._rows.row(state))[0])
        self._roots[root], self._decisions = None, None
        if not table.expanded[root]:
            table.expand(np.array([root]))
        slack = SLACK_SHARE * gap * min(self._least_price, float(table.stop[root]))
        self._looked = 0
        self._settled.clear()
        while True:
            settled = self._look_beyond(beyond)
            visits = self._improve(root, slack)
            effort.spend(ROUND_STEPS + TRANSITION_STEPS * table.transitions)
            if table.high[root] - table.low[root] <= gap * table.high[root]:
                return None
            missed = visits * (table.high - table.low)
            missed[table.expanded] = 0.0
            missed[settled] = 0.0
            chosen = _most_missed(missed, max(MIN_EXPANDED, int(table.expanded.sum())))
            outside = [number for number in chosen.tolist() if number in self._beyond]
            if outside:
                return self._beyond[outside[0]]
            if not len(chosen):
                return None
            before = len(table.states)
            self._expand(chosen, visits)
            effort.spend(STATE_STEPS * (len(table.states) - before))

    def decision(self, state: State) -> _Decision | None:
        """Return the best action in a state, and the lower and upper bound of its expected cost, in [s].

        The result is None if the search has not examined the options of the state.
        """
        number = self._table.number(self._rows.key(state))
        if number is None or not self._table.expanded[number]:
            return None
        made = self._made()
        return self._decisions_in(np.array([number]), made.options, made.cost)[number]

    def likely_decision(self, state: State) -> _Decision | None:
        """Return the best action in a state, and the lower and upper bound of its expected cost, in [s].

        The result is None if the best policy never leads to the state, or if it leads to more than
        `MAX_POLICY_STATES` states and this one is not among the `MAX_POLICY_STATES` most visited.
        """
        number = self._table.number(self._rows.key(state))
        return None if number is None else self._made().likely.get(number)

    def _made(self) -> _Decisions:
        """Return the decisions by the upper bounds, which are made once after each search."""
        if self._decisions is None:
            table = self._table
            best = table.choices(table.high)
            visits = self._equations(np.array(list(self._roots)), best.option).visits
            visits[~table.expanded] = 0.0
            likely = visits > 0.0
            if int(likely.sum()) > MAX_POLICY_STATES:
                likely &= visits >= np.partition(visits, -MAX_POLICY_STATES)[-MAX_POLICY_STATES]
            decisions = self._decisions_in(np.flatnonzero(likely), best.option, best.cost)
            self._decisions = _Decisions(best.option, best.cost, decisions)
        return self._decisions

    def _decisions_in(self, states: IntArray, options: IntArray, costs: FloatArray) -> dict[int, _Decision]:
        """Return the decisions in some states, by the states' numbers.

        Args:
            states: (n,) numbers of the states.
            options: (states,) number of the best option in each state of the table.
            costs: (states,) cost of each, in [s].
        """
        table, option, cost = self._table, options[states], costs[states]
        low = np.minimum(cost, table.low[states])
        actions = [
            None if item == STOP_CHOICE else self._rows.actions[table.action(item)]
            for item in option.tolist()
        ]
        return dict(zip(states.tolist(), zip(actions, cost.tolist(), low.tolist(), strict=True), strict=True))

    def _expand(self, chosen: IntArray, visits: FloatArray) -> None:
        """Expand states, and those behind them that the policy by the lower bounds is likely to reach.

        Args:
            chosen: (n,) numbers of the states.
            visits: (states,) expected number of visits to each state of the table.
        """
        table = self._table
        most = int(ROUND_GROWTH * table.expanded.sum())
        for _ in range(MAX_ROUND_LEVELS):
            row, to, p = table.after(table.expand(chosen))
            behind = np.bincount(to, visits[chosen][row] * p, len(table.states))
            new = np.zeros(len(behind) - len(visits))
            visits = np.concatenate((visits, new)) + behind
            missed = behind * (table.high - table.low)
            missed[table.expanded | (table.states[:, 0] >= self._rows.inside)] = 0.0
            most -= len(chosen)
            chosen = _most_missed(missed, max(0, most))
            if not len(chosen):
                return

    def _look_beyond(self, beyond: Bounds) -> IntArray:
        """Set the bounds of the states beyond the component; return the numbers (k,) of those that are
        settled.
        """
        table = self._table
        new = table.states[self._looked :]
        for offset in np.flatnonzero(new[:, 0] >= self._rows.inside).tolist():
            number = self._looked + offset
            state = self._beyond.setdefault(number, self._rows.state(new[offset]))
            if (found := beyond(state)) is not None:
                table.low[number], table.high[number] = found
                self._settled[number] = None
        self._looked = len(table.states)
        return np.array(list(self._settled), np.int64)

    def _improve(self, root: int, slack: float) -> FloatArray:
        """Improve all bounds; return the number of visits (states,) of the policy that looks best, by state.

        Args:
            root: number of the first state.
            slack: difference of values that does not matter, in [s].
        """
        table, low, high = self._table, self._table.low, self._table.high
        table.raise_low(LOW_SWEEPS)
        solved = self._equations(np.array([root]), table.choices(low).option)
        self._raise_low(solved, slack)
        high[solved.states] = np.minimum(high[solved.states], solved.high)
        table.reduce_high(HIGH_SWEEPS)
        return solved.visits

    def _raise_low(self, solved: _Solution, slack: float) -> None:
        """Take the values of a policy for lower bounds if no choice improves them by more than slack.

        With T the best choice, T(v) >= v - slack implies T((1 - e) v) >= (1 - e) v, e = slack / least price.
        """
        table = self._table
        values = table.low.copy()
        values[solved.states] = np.minimum(solved.low, table.stop[solved.states])
        if np.all(table.improved(values)[solved.states] >= values[solved.states] - slack):
            shrunk = values[solved.states] * (1.0 - slack / self._least_price)
            table.low[solved.states] = np.maximum(table.low[solved.states], shrunk)

    def _equations(self, roots: IntArray, options: IntArray) -> _Solution:
        """Solve the equations of a policy.

        Args:
            roots: (n,) numbers of the states in which its runs start.
            options: (states,) number of the option chosen in each state of the table.
        """
        from scipy.sparse.linalg import splu  # late: most networks are small

        table = self._table
        states = table.reached(roots, options)
        states = states[table.expanded[states]]
        # States with more Fails come first: the equations become nearly triangular.
        states = states[np.argsort(-table.states[states, 1:].sum(axis=1, dtype=np.int64), kind="stable")]
        size = len(states)
        place = np.full(len(options), -1)
        place[states] = np.arange(size)
        row, to, p = table.after(options[states])
        inside = place[to] >= 0
        links = p[inside] * MAX_PROBABILITY, (row[inside], place[to[inside]])
        factors = splu(
            (eye_array(size) - csc_array(links, shape=(size, size))).tocsc(),
            permc_spec="NATURAL",
            diag_pivot_thresh=0.0,
        )
        row, to, p = row[~inside], to[~inside], p[~inside]
        price = table.prices(states, options[states])
        low, high = (
            factors.solve(price + np.bincount(row, p * values[to], size))
            for values in (table.low, table.high)
        )
        begins = np.zeros(size)
        begins[place[roots[table.expanded[roots]]]] = 1.0
        visits = np.zeros(len(options))
        visits[states] = factors.solve(begins, "T")
        np.add.at(visits, to, visits[states][row] * p)
        return _Solution(states, low, high, visits)


def _most_missed(missed: FloatArray, most: int) -> IntArray:
    """Return the states (n,) that leave most of the gap open, the largest first.

    Args:
        missed: (states,) share of each in the gap.
        most: maximum number.
    """
    open_ = np.flatnonzero(missed > 0.0)
    open_ = open_[np.argsort(-missed[open_], kind="stable")]
    total = np.cumsum(missed[open_])
    count = int(np.searchsorted(total, EXPANDED_SHARE * total[-1])) + 1 if len(open_) else 0
    return open_[: min(count, most)]
