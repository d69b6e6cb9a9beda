"""Flow of probability through the states of the rule, many states at once."""

from __future__ import annotations

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
"""Least probability of a state that is followed: in the first pass, and its factor from pass to pass."""
MAX_WAYS = 300
"""Maximum number of a network's actions for which all routes are computed at once."""
MAX_BATCH_STATES = 20_000
"""Maximum number of states that are followed at once."""
BATCH_STEPS, STATE_STEPS, ROUTE_STEPS = 30.0, 0.3, 0.01
"""Effort of a batch, of each state in it, and of each action in the routes of each state."""


class FlowResult(NamedTuple):
    """Ends of the runs that a flow has followed."""

    ends: Ends
    starts: FloatArray
    """(actions,) average number of starts of each action."""
    ended: FloatArray
    """(situations, ends) probability that a run ends in each situation, with a column for each `ChainEnd`."""
    skips: float
    """Average number of skips."""


def can_flow(network: ActionNetwork) -> bool:
    """Return whether each action of a network leads towards the goal, or by its Fail to states with more
    Fails.
    """
    plain = not any(a.others or a.unlimited or a.renewals for a in network.actions)
    return plain and 0 < len(network.actions) <= MAX_WAYS


class RuleFlow:
    """States of the rule, followed by their number of Fails: each Fail leads on to the next number.

    While nothing fails, all states with the same Fails share one tree of routes. States that are too
    unlikely wait for the next pass, in which the least probability is smaller.
    """

    def __init__(self, network: ActionNetwork, chances: Chances, effort: Effort) -> None:
        """Prepare the flow in a network for which `can_flow` holds.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None for a skip.
            effort: budget of the flow.
        """
        self._network, self._effort = network, effort
        maker = StepMaker(network, False, effort, chances)
        self._codes = StateCodes(network, maker.after)
        self._walk = RouteWalk(network, chances, maker, self._codes)
        self._waiting: dict[int, FlowStates] = {}

    def result(self, start: State, max_open: float = MAX_OPEN) -> FlowResult:
        """Follow all runs from a state until few are open, or the budget is spent.

        Args:
            start: the state.
            max_open: total probability of states not followed yet, below which the flow ends.
        """
        mass = np.zeros(self._walk.ends.shape[2])
        mass[0] = 1.0
        self._waiting[0] = self._codes.one(start, mass)
        least = FIRST_LEAST
        try:
            while sum(states.p.sum() for states in self._waiting.values()) > max_open:
                self._pass(least)
                least *= LEAST_FACTOR
        except TooMuch:
            pass  # the budget is spent: runs that come to the states that wait are not known
        return self._found()

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
