"""Decisions of a network's rule, made once and shared by explorations from several states."""

from __future__ import annotations

import math

from handcart.networks.graph.network import ActionNetwork

from .effort import Effort, TooMuch
from .policy import Chances, Policy, TooLarge, visited
from .step_maker import State, Step, StepMaker


class StepTable:
    """Decisions of the rule by state.

    An exploration spends the same budget whether or not its states were explored before, so that its
    result does not depend on earlier ones.
    """

    def __init__(self, network: ActionNetwork, chances: Chances) -> None:
        """Prepare the search; no decision is made yet.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None for a skip.
        """
        self._network, self._spent = network, Effort(math.inf)
        self._maker = StepMaker(network, False, self._spent, chances)
        self._preparation = self._spent.spent
        self._made: dict[State, tuple[Step, float]] = {}

    def policy(self, start: State, effort: Effort) -> Policy:
        """Return the decisions in all states that runs can reach from a state.

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
