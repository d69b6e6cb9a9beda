"""Decisions of a network's rule, made once and shared by explorations from several states."""

from __future__ import annotations

import math

from handcart.networks.graph.network import ActionNetwork

from .effort import Effort, TooMuch
from .policy import Chances, Policy, TooLarge, visited
from .step_maker import State, Step, StepMaker


class StepTable:
    """Table of the actions that the rule `take the cheapest route` chooses, by state, each computed once.

    A call of `policy` has a budget of computing steps. A kept decision is charged like a new one, so that
    results do not depend on earlier calls.
    """

    def __init__(self, network: ActionNetwork, chances: Chances) -> None:
        """Prepare the search; no decision is made yet.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None if it skips an element.
        """
        self._network, self._spent = network, Effort(math.inf)
        self._maker = StepMaker(network, False, self._spent, chances)
        self._preparation = self._spent.spent
        self._made: dict[State, tuple[Step, float]] = {}

    def policy(self, start: State, effort: Effort) -> Policy:
        """Return the rule's decisions (the cheapest route is taken) in all states that runs can reach from a
        state.

        Args:
            start: state in which the runs begin.
            effort: budget for these states.

        Raises:
            TooLarge: the budget does not suffice.
        """

        def step(state: State) -> Step:
            made, cost = self._step(state)
            effort.spend(cost)
            return made

        try:
            effort.spend(self._preparation)
        except TooMuch:
            raise TooLarge(self._network, 0) from None
        found = visited(self._network, start, step)
        if not found.is_complete:
            raise TooLarge(self._network, len(found.steps))
        return found

    def _step(self, state: State) -> tuple[Step, float]:
        if state not in self._made:
            before = self._spent.spent
            made = self._maker.step(state)
            self._made[state] = made, self._spent.spent - before
        return self._made[state]
