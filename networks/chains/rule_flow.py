"""Flow of probability through the states of the rule, many states at once."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.networks.graph.network import ActionNetwork
from handcart.robotics.numerics.arrays import FloatArray, IntArray

from .chain_rows import ChainEnd
from .effort import Effort, TooMuch
from .ends import Ends
from .flow_states import FlowStates, StateCodes
from .moments import Moments
from .policy import Chances
from .route_walk import RouteWalk
from .step_maker import State, StepMaker

MAX_OPEN = 1e-4
"""Default of the total probability of states not followed yet, below which a flow ends."""
FIRST_LEAST, LEAST_FACTOR = 1e-5, 0.25
"""Least probability of a state that is followed in the first pass, and its factor in the second."""
MIN_LEAST_FACTOR = 1e-3
"""Smallest factor of the least probability from one pass to the next."""
LAST_FACTOR = 0.7
"""Largest factor of the least probability from one pass to the next."""
NEAR_FACTOR = 1.0 / 16.0
"""Predicted factor of the last pass above which it is not divided into two."""
MAX_WAYS = 300
"""Maximum number of a network's actions for which all routes are computed at once."""
MAX_BATCH_STATES = 20_000
"""Maximum number of states that are followed at once."""
DECISION_STEPS = 12.0
"""Least effort of a `StepMaker` for a state with a route, besides one step for each action that failed."""
NO_WAY_STEPS = 7.0
"""Steps that a state without a route may cost less."""
BATCH_STEPS, STATE_STEPS, ROUTE_STEPS = 30.0, 0.3, 0.01
"""Effort of a batch, of each state in it, and of each action in the routes of each state."""


class FlowResult(NamedTuple):
    """Ends of the runs that a `RuleFlow` has followed along cheapest routes, and how often they started each
    action.
    """

    ends: Ends
    starts: FloatArray
    """(actions,) average number of starts of each action."""
    ended: FloatArray
    """(situations, ends) probability that a run ends in each situation, with a column for each `ChainEnd`."""
    skips: float
    """Average number of skips."""


def can_flow(network: ActionNetwork) -> bool:
    """Return whether the ends of a network's runs can be computed by `RuleFlow`, which follows runs Fail by
    Fail.

    Following ends because each Fail leads to a state with more counted Fails, and attempts are limited. So no
    action may have unlimited attempts or attempts that are renewed. Each action must lead to one situation
    after its Success, and the network may have at most `MAX_WAYS` actions.
    """
    plain = not any(a.others or a.unlimited or a.renewals for a in network.actions)
    return plain and 0 < len(network.actions) <= MAX_WAYS


class RuleFlow:
    """Computation of the ends of all runs that follow the rule, in passes over states with 0, 1, 2... Fails.

    The rule takes the cheapest route to the goal. While nothing fails, all states with the same Fails share
    one tree of routes. States whose probability is below a threshold are left for the next pass, which has a
    smaller threshold.
    """

    def __init__(self, network: ActionNetwork, chances: Chances, effort: Effort) -> None:
        """Prepare the flow in a network for which `can_flow` holds.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None if it skips an element.
            effort: budget of the flow.
        """
        self._network, self._effort = network, effort
        maker = StepMaker(network, False, effort, chances)
        self._codes = StateCodes(network, maker.after)
        self._walk = RouteWalk(network, chances, maker, self._codes)
        self._waiting: dict[int, FlowStates] = {}

    def result(self, start: State, max_open: float = MAX_OPEN) -> FlowResult:
        """Return how all runs from a state may end, with probabilities, by following them until few are
        unfinished or the budget of computation is spent.

        Args:
            start: the state.
            max_open: probability of unfinished runs, from 0 to 1, at which following them stops.
        """
        self._begin(start)
        least, before, factor = FIRST_LEAST, 1.0, 1.0
        try:
            self._pass(least)
            while (left := self._open()) > max_open:
                factor = _least_factor(factor, left / before, max_open / left)
                least, before = least * factor, left
                self._pass(least)
        except TooMuch:
            pass  # the budget is spent: runs that come to the states that wait are not known
        return self._found()

    def _begin(self, start: State) -> None:
        mass = np.zeros(self._walk.ends.shape[2])
        mass[0] = 1.0
        self._waiting[0] = self._codes.one(start, mass)

    def _open(self) -> float:
        """Return the total probability of states that wait."""
        return float(sum(states.p.sum() for states in self._waiting.values()))

    def least_steps(self, start: State, most: float) -> float:
        """Return a lower bound of the number of search steps that the computation of all runs needs.

        In each state that a run can reach, the cheapest plan to the goal has to be searched.

        Args:
            start: state in which the runs begin.
            most: number of steps above which counting ends; the returned bound may then be far below the
                needed number.
        """
        self._begin(start)
        walk, seen, steps = self._walk, set[bytes](), 0.0
        while self._waiting and steps - NO_WAY_STEPS * walk.stuck - walk.stuck_fails <= most:
            level = min(self._waiting)
            # Fails that no longer matter are forgotten, so that a state may come back with more of them.
            states = self._waiting[level]
            keys = [row.tobytes() for row in np.column_stack((states.place, states.counts))]
            new = np.flatnonzero([key not in seen for key in keys])
            seen.update(keys)
            steps += DECISION_STEPS * len(new) + np.count_nonzero(states.counts[new])
            self._waiting[level] = states.at(new)
            self._follow(level, np.arange(len(new)))
        return steps - NO_WAY_STEPS * walk.stuck - walk.stuck_fails

    def _pass(self, least: float) -> None:
        """Follow all states that are likely enough, the fewest Fails first."""
        level = min(self._waiting)
        while level <= max(self._waiting, default=-1):
            if level in self._waiting:
                self._follow(level, np.flatnonzero(self._waiting[level].p >= least))
            level += 1

    def _follow(self, level: int, chosen: IntArray) -> None:
        """Follow the chosen states; all of them have the same number of Fails.

        Args:
            level: the number of Fails.
            chosen: (n,) row numbers of the states.
        """
        states, routes = self._waiting[level], ROUTE_STEPS * len(self._network.actions)
        for begin in range(0, len(chosen), MAX_BATCH_STATES):
            batch = chosen[begin : begin + MAX_BATCH_STATES]
            self._effort.spend(BATCH_STEPS + len(batch) * (STATE_STEPS + routes))
            failed = list(self._walk.after(states.at(batch)))
            states.mass[batch] = 0.0
            rest = self._waiting.get(level + 1)
            self._waiting[level + 1] = self._codes.merged(failed if rest is None else [*failed, rest])
        self._waiting[level] = states.at(np.flatnonzero(states.p > 0.0))
        for item in (level, level + 1):
            if item in self._waiting and not len(self._waiting[item].place):
                del self._waiting[item]

    def _found(self) -> FlowResult:
        ends = self._walk.ends
        for states in self._waiting.values():
            np.add.at(ends[:, ChainEnd.UNKNOWN], states.place, states.mass)
        total = ends.sum(axis=0)
        both = total[:, :3] + (total[:, 3:] if total.shape[1] > 3 else 0.0)
        skipped = total[ChainEnd.GOAL, 3:] if total.shape[1] > 3 else np.zeros(3)
        named = (total[ChainEnd.GOAL, :3], skipped, *both[1:])
        found = Ends(*(Moments(*map(float, item)) for item in named))
        return FlowResult(found, self._walk.starts, ends[:, :, ::3].sum(axis=2), self._walk.skips)


def _least_factor(before: float, closed: float, needed: float) -> float:
    """Return the factor of the least probability for the next pass.

    The open probability is taken for a power of the least probability; a pass that would go far is divided in
    two, because the power changes on the way.

    Args:
        before: factor of the last pass; 1 for the first.
        closed: factor by which the last pass reduced the open probability.
        needed: factor by which it is still to be reduced.
    """
    if before >= 1.0 or closed >= 1.0:
        return LEAST_FACTOR
    predicted = before ** (math.log(needed) / math.log(closed))
    factor = predicted if predicted >= NEAR_FACTOR else math.sqrt(predicted)
    return min(LAST_FACTOR, max(MIN_LEAST_FACTOR, factor))
