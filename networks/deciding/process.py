"""A network as a Markov decision process: states, options, and what they cost."""

from __future__ import annotations

from copy import copy
from typing import NamedTuple

import networkx as nx

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.policy import Chances, fail_shares, success_shares
from handcart.networks.chains.step_maker import Aftermath, State, Step
from handcart.networks.graph.ahead import ways_of
from handcart.networks.graph.network import Action, ActionNetwork

MIN_PROBABILITY = 1e-12
"""Probability below which a result counts as impossible, because sums of decimals are rounded."""


class ProcessOption(NamedTuple):
    """An action that can be started in a state, with its expected cost and the states that may follow."""

    action: Action
    cost: float
    """Its cost, with the share of a person's price for GiveUp, in [s]."""
    stays: float
    """Probability that the state remains as it is."""
    leads: tuple[tuple[float, State], ...]
    """Other states that may follow, short of the goal, each with its probability."""


class Process:
    """A network as a Markov decision process, whose options are the actions that can be started in a state.

    A state is a situation with the number of Fails so far of each action that a run can still start.
    """

    def __init__(self, network: ActionNetwork, chances: Chances, person_s: float) -> None:
        """Prepare the options.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None if it skips an element.
            person_s: price of an end short of the goal for each element of a `repeat` that it leaves undone,
                in [s]; without a `repeat`, that of an end.
        """
        self.network, self.chances, self.person_s = network, chances, person_s
        self.after = Aftermath(network)
        self.out: dict[str, list[Action]] = {name: [] for name in network.situations}
        """Actions out of each situation."""
        for action in network.actions:
            self.out[action.source].append(action)
        self.part: dict[str, int] = {}
        """Number of the strongly connected component of each situation; successors come first."""
        self.parts: list[list[str]] = []
        """Situations of each component."""
        order = {name: number for number, name in enumerate(network.situations)}
        for number, names in enumerate(nx.strongly_connected_components(ways_of(network))):
            self.parts.append(sorted(names, key=lambda name: order[name]))
            self.part |= dict.fromkeys(names, number)
        self._undone = self._elements_left()

    def believing(self, chances: Chances) -> Process:
        """Return a copy of this process with other outcome probabilities of the actions."""
        other = copy(self)
        other.chances = chances
        return other

    def stop_price(self, situation: str) -> float:
        """Return the price of a run that ends in a situation short of the goal, in [s].

        It is the price of calling a person. If the run was in a part of the task that is repeated for the
        elements of a list, this price is multiplied by the number of elements left undone.
        """
        return self.person_s * self._undone[self.part[situation]]

    def price(self, action: Action) -> float:
        """Return the expected cost of starting an action, in [s].

        It includes the price of calling a person, times the probability of GiveUp. An action that only skips
        one element of a repeated part of the task costs as much as calling a person.
        """
        if action.binding is None:
            return self.person_s
        chance = self.chances[action.index] or Chance(1.0)
        return action.cost_s + chance.give_up * self.stop_price(action.source)

    def _elements_left(self) -> list[int]:
        """Return for each component how many elements an end in it leaves undone; at least 1."""
        left: list[int] = []
        for number, names in enumerate(self.parts):
            going_on = (name for name in names if name != self.network.goal)  # as in `ways_of`
            actions = (action for name in going_on for action in self.out[name])
            nexts = ((self.part[to], action.binding is None) for action in actions for to in action.leads_to)
            left.append(max((left[to] + skips for to, skips in nexts if to != number), default=0))
        return [max(1, count) for count in left]

    def endings(self, action: Action) -> list[tuple[float, str]]:
        """Return the situations that an action may lead to, each with its probability; Fails are the last."""
        chance = Chance(1.0) if action.binding is None else self.chances[action.index] or Chance(1.0)
        nexts = [action.target, *(other.target for other in action.others)]
        found = [
            (chance.success * p, to) for p, to in zip(success_shares(action, chance), nexts, strict=True)
        ]
        failed = [action.on_fail, *(ending.target for ending in action.fail_endings)]
        pairs = zip(fail_shares(action, chance), failed, strict=True)
        return [*found, *((chance.fail * p, to or action.source) for p, to in pairs)]

    def options(self, state: State) -> list[ProcessOption]:
        """Return the actions that can be started in a state, each with its cost and the states that may
        follow.
        """
        fails = dict(state.fails)
        return [
            self._option(state, action, fails)
            for action in self.out[state.situation]
            if not action.allowance.is_out(fails.get(action.counter, 0))
        ]

    def step(self, state: State, action: Action) -> Step:
        """Return the start of an action in a state as a `Step`, with the states to which the action's results
        lead.
        """
        fails = state.fails
        succeeded = self.after.successes(action, fails)
        chance = None if action.binding is None else self.chances[action.index]
        failed, *by = self.after.fails(action, fails, chance is not None and chance.fail > MIN_PROBABILITY)
        return Step(action, succeeded, failed, failed_by=tuple(by))

    def _option(self, state: State, action: Action, fails: dict[int, int]) -> ProcessOption:
        step, chances = self.step(state, action), self.endings(action)
        leads: dict[State, float] = {}
        for (p, _), after in zip(chances, (*step.succeeded, *step.all_failed), strict=True):
            if after is not None and p > 0.0 and after.situation != self.network.goal:
                leads[after] = leads.get(after, 0.0) + p
        stays = leads.pop(state, 0.0)
        return ProcessOption(action, self.price(action), stays, tuple((p, name) for name, p in leads.items()))
