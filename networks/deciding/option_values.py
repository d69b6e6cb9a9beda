"""Expected results of each action out of a situation: probability of the goal and time, if it is done
next.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import Chances, Policy, TooLarge
from handcart.networks.chains.policy_chain import policy_chain, values_of_states
from handcart.networks.chains.step_maker import State
from handcart.networks.chains.step_table import StepTable
from handcart.networks.graph.network import Action, ActionNetwork

from .best_planner import chances_of
from .best_policy import BestPolicy, PolicyName
from .process import MIN_PROBABILITY, Process

VALUE_STEPS = 200_000
"""Budget of the figures of one state, in steps."""


class OptionValue(NamedTuple):
    """Expected result of a run, as probability of the goal and time, if an action is done now and the
    network's policy decides afterwards.
    """

    goal: float
    """Probability that the goal is reached with nothing left undone."""
    mean_s: float
    """Expected time from now to the run's end, in [s]."""


class OptionValues:
    """Computation of the expected result of a run (probability of the goal, and time) for each action that
    could be done next.
    """

    def __init__(
        self, network: ActionNetwork, chances: Chances | None = None, policy: str | None = None
    ) -> None:
        """Prepare the figures.

        Args:
            network: the network.
            chances: outcome probabilities of each action; None: those of the file.
            policy: policy that decides afterwards; None: the network's.
        """
        self._network = network
        self._chances = chances_of(network) if chances is None else chances
        self._policy_name = policy or network.policy
        self._process = Process(network, self._chances, network.person_s)
        self._rule = StepTable(network, self._chances) if self._policy_name == "rule" else None
        self._known: dict[State, OptionValue] = {}

    @property
    def are_known(self) -> bool:
        """True if each action has a probability of Success, so that `of` can compute expected results."""
        return all(a.p_success is not None for a in self._network.actions if a.binding is not None)

    def of(self, action: Action, counts: Mapping[int, int], hopes: bool = False) -> OptionValue | None:
        """Return the expected probability of the goal and time of a run in which an action is done next.

        The result is None if there are too many states.

        Args:
            action: the action.
            counts: number of Fails so far for each counter (`Action.counter`); actions that share attempts
                share a counter.
            hopes: True if the plan needs the action's Fail: then its Success uses up an attempt.
        """
        process, goal, mean = self._process, 0.0, action.cost_s if action.binding else 0.0
        here = process.after.at(action.source, counts)
        step = process.step(here, action)
        succeeded = process.after.successes(action, here.fails, (), hopes)
        nexts = zip(process.endings(action), (*succeeded, *step.all_failed), strict=True)
        for (p, _), state in nexts:
            if state is None or p <= MIN_PROBABILITY:
                continue
            try:
                after = self._after(state)
            except TooLarge:
                return None
            goal, mean = goal + p * after.goal, mean + p * after.mean_s
        return OptionValue(goal, mean)

    def _after(self, state: State) -> OptionValue:
        if state.situation == self._network.goal:
            return OptionValue(1.0, 0.0)
        if state not in self._known:
            self._follow(state)
        return self._known[state]

    def _follow(self, start: State) -> None:
        if self._rule is not None:
            # The rule decides alike wherever a run began: a chain has the values of all its states.
            values = values_of_states(self._rule.policy(start, Effort(VALUE_STEPS)), self._chances)
            self._known |= {state: OptionValue(*value) for state, value in values.items()}
            return
        ends = policy_chain(self._best_policy(start), self._chances).ends
        self._known[start] = OptionValue(ends.goal.p, ends.total().first)

    def _best_policy(self, start: State) -> Policy:
        name: PolicyName = "goal_probability" if self._policy_name == "goal_probability" else "expected_cost"
        best = BestPolicy(self._network, self._chances, name, self._network.person_s, Effort(VALUE_STEPS))
        return best.policy(start)


class RunOptionValues:
    """Cache of the expected results of one run for each action that could be next (`OptionValues`).

    It is kept until the run's outcome probabilities or its policy change.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """Prepare the figures of a run in a network."""
        self._network = network
        self._key: tuple[tuple[Chance | None, ...] | None, str] | None = None
        self._values: OptionValues | None = None

    def by(self, chances: Chances | None, policy: str | None) -> OptionValues:
        """Return the object that computes, for each action that the run could do next, the probability of the
        goal and the time.

        Args:
            chances: outcome probabilities of each action; None: those of the task's file.
            policy: policy that chooses the actions after the first; None: the network's.
        """
        key = None if chances is None else tuple(chances), policy or self._network.policy
        if self._values is None or key != self._key:
            self._key, self._values = key, OptionValues(self._network, chances, policy)
        return self._values
