"""Exact forecast of how runs of a network end."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from itertools import accumulate

from handcart.networks.chains.effort import Effort, TooMuch
from handcart.networks.chains.ends import AT_GOAL, Ends
from handcart.networks.chains.policy import Policy, State, TooLarge, budget_of, explored, likely_policy
from handcart.networks.chains.policy_chain import Chain, Chances, policy_chain
from handcart.networks.chains.rule_flow import RuleFlow, can_flow
from handcart.networks.chains.stage import Stage
from handcart.networks.chains.stages import stages
from handcart.networks.graph.network import MAX_COST_S, ActionNetwork

IMPOSSIBLE_SHARE = 0.05
"""Share of the budget for states that only Fails of probability 0 lead to; slopes need them."""
LIKELY_SHARE = 0.3
"""Share of the remaining budget for likely states, if a `RuleFlow` follows many more of them afterwards."""
TRIAL_SHARE = 0.1
"""Share of a search's budget that is tried before its states are counted."""
STAGE_STEPS = 20
"""Steps of effort for a stage whose chain is known already."""
Change = Callable[[Stage, Collection[int]], Stage]
"""Function that takes a stage and numbers of its actions, and returns the stage with these actions
changed.
"""


@dataclass(frozen=True)
class Forecast:
    """Probabilities of the ends of a run, and its expected cost, if attempts do not depend on each other."""

    goal: float
    """Probability that the goal is reached, with nothing left undone (status 0)."""
    left_undone: float
    """Probability that the goal is reached with elements of a repeat left undone (status 3)."""
    no_way: float
    """Probability that nothing is left to try (status 3)."""
    give_up: float
    """Probability that a person is needed (status 4)."""
    cost_s: float
    """Expected cost of a run, in [s]: the costs of the actions that it starts, whatever their outcome."""
    cost_sigma_s: float
    """Standard deviation of the cost, in [s]."""
    unknown: float = 0.0
    """Probability that a run comes to a state that was not looked at; 0: all figures are exact.

    Each of the probabilities above is too small by at most this, and costs after such states are missing.
    """
    cost_high_s: float = 0.0
    """Upper bound of the expected cost, in [s]."""

    @property
    def goal_high(self) -> float:
        """Upper bound of the probability that a run reaches the goal."""
        return min(1.0, self.goal + self.unknown)


def forecast(network: ActionNetwork, chances: Chances) -> Forecast:
    """Return the probabilities with which runs of a network end at the goal or otherwise, and their expected
    cost.

    Args:
        network: the network.
        chances: outcome probabilities of each action, in the order of the network; None for a skip, an action
            that leaves an element of a list undone over which the task repeats actions.

    Raises:
        TooLarge: a part of the network has too many states.
    """
    return Forecaster(network, chances).forecast()


class Forecaster:
    """Computation of the probabilities of a run's ends and of its cost, by stages, which are parts of the
    network.

    Each successful run passes all stages one after the other.

    Of equal stages only one is computed, as a Markov chain. Its states are a situation and the number of
    Fails of each action that can still come up. If there are too many states, only the most likely ones are
    expanded; `Forecast.unknown` is the probability of the others.
    """

    def __init__(self, network: ActionNetwork, chances: Chances, effort: Effort | None = None) -> None:
        """Create a forecaster; nothing is computed before a method asks for it.

        Args:
            network: the network.
            chances: the outcome probabilities of each action, by its number; None if it skips an element.
            effort: budget of all forecasts together; None: `budget_of`.
        """
        self._chances = chances
        self._network = network
        self._dearest = max((a.cost_s for a in network.actions if a.binding), default=MAX_COST_S)
        self._effort = effort or Effort(budget_of(network))
        self._stages = stages(network)
        self._stage_of = {number: at for at, stage in enumerate(self._stages) for number in stage.numbers}
        self._chains: dict[object, Chain] = {}
        self._before: list[Ends] = []
        self._behind: list[Ends] = []

    def forecast(
        self, change: Change | None = None, numbers: Collection[int] = (), effort: Effort | None = None
    ) -> Forecast:
        """Return the forecast of the network, optionally with some of its actions changed.

        Args:
            change: function that changes actions of a stage (consecutive part of the network); None: no
                change.
            numbers: numbers, in the network, of the actions to change.
            effort: budget for computing the changed stages, in steps of search; None: that of the forecaster.

        Raises:
            TooLarge: a stage has too many states.
        """
        self._reckon_whole()
        changed = sorted({self._stage_of[number] for number in numbers if number in self._stage_of})
        if change is None or not changed:
            return self._forecast_of(self._behind[0])
        ends, effort = self._before[changed[0]], effort or self._effort
        for at in range(changed[0], changed[-1] + 1):
            effort.spend(STAGE_STEPS)
            ends = ends.then(self._chain(self._stages[at], change, numbers, effort).ends)
        return self._forecast_of(ends.then(self._behind[changed[-1] + 1]))

    def _reckon_whole(self) -> None:
        """Compute how runs end before each stage, and from each stage on."""
        if self._behind:
            return
        ends = [self._chain(stage).ends for stage in self._stages]
        self._before = list(accumulate(ends, Ends.then, initial=AT_GOAL))
        behind = accumulate(reversed(ends), lambda rest, each: each.then(rest), initial=AT_GOAL)
        self._behind = list(behind)[::-1]

    def chains(self) -> Iterator[tuple[Stage, Chain]]:
        """Yield the stages (parts of the network that each successful run passes exactly once) in the order
        in which runs pass them, each with its Markov chain.
        """
        yield from ((stage, self._chain(stage)) for stage in self._stages)

    def starts(self) -> list[float]:
        """Return for each action the average number of times that a run starts it."""
        found, comes = [0.0] * len(self._chances), 1.0
        for stage in self._stages:
            chain = self._chain(stage)
            for number, starts in zip(stage.numbers, chain.starts, strict=True):
                found[number] = comes * starts
            comes *= chain.ends.goal.p + chain.ends.skipped.p
        return found

    def slopes(self) -> list[float]:
        """Return for each action the derivative of the probability of the goal by the action's probability of
        Success.

        The action's probability of Fail becomes smaller by as much as that of Success becomes larger.
        """
        found = [0.0] * len(self._chances)
        chains = [self._chain(stage) for stage in self._stages]
        behind = [1.0]
        for chain in reversed(chains):
            behind.append(behind[-1] * chain.ends.goal.p)
        before = 1.0
        for stage, chain, after in zip(self._stages, chains, behind[-2::-1], strict=True):
            for number, slope in zip(stage.numbers, chain.slopes, strict=True):
                found[number] = before * slope * after
            before *= chain.ends.goal.p
        return found

    def _chain(
        self,
        stage: Stage,
        change: Change | None = None,
        numbers: Collection[int] = (),
        effort: Effort | None = None,
    ) -> Chain:
        if change is not None and not set(numbers).isdisjoint(stage.numbers):
            stage = change(stage, numbers)
        chances = [self._chances[number] for number in stage.numbers]
        key = stage.shape, tuple(chances)
        if key not in self._chains:
            found = _solved(stage.network, chances, (effort or self._effort).half(), change is None)
            self._chains[key] = found
        return self._chains[key]

    def _forecast_of(self, ends: Ends) -> Forecast:
        total, unknown = ends.total(), ends.unknown.p
        sigma = math.sqrt(max(0.0, total.second - total.first**2))
        short = ends.no_way.p, ends.give_up.p
        high = total.first + (unknown * self._network.bound() * self._dearest if unknown else 0.0)
        return Forecast(ends.goal.p, ends.skipped.p, *short, total.first, sigma, unknown, high)


def _solved(network: ActionNetwork, chances: Chances, effort: Effort, partly: bool) -> Chain:
    """Return the chain of a stage: of all states, or if they are too many, of possible or likely states.

    Raises:
        TooLarge: the budget does not suffice, and `partly` does not allow a chain of likely states only.
    """
    certain = any(chance is not None and chance.fail <= 1e-12 for chance in chances)
    share = effort.part(IMPOSSIBLE_SHARE) if certain else effort.half()
    found = _explored(network, chances, share, impossible=True)
    if not found.is_complete and certain:
        found = _explored(network, chances, effort.half(), impossible=False)
    if not found.is_complete:
        if not partly:
            raise TooLarge(network, len(found.steps))
        return _likely(network, chances, effort, found.start)
    return policy_chain(found, chances)


def _explored(network: ActionNetwork, chances: Chances, effort: Effort, impossible: bool) -> Policy:
    """Return the decisions in all states that runs can reach; with fewer states where the budget does not
    suffice.

    A flow counts the states many times faster than their decisions are made, so that a search that cannot
    succeed is not begun.

    Args:
        network: the network.
        chances: outcome probabilities of each action; None for a skip.
        effort: budget; a search that is left out spends it, too.
        impossible: whether to include states that only Fails of probability 0 lead to.
    """
    needed = None if impossible else chances
    trial = Effort(TRIAL_SHARE * effort.left)
    found = explored(network, effort=trial, chances=needed)
    if found.is_complete:
        effort.spend(trial.spent)
        return found
    if can_flow(network):
        steps = RuleFlow(network, chances, Effort(math.inf)).least_steps(found.start, effort.left)
        if steps > effort.left:
            effort.spend(math.floor(effort.left))
            return found
    return explored(network, effort=effort, chances=needed)


def _likely(network: ActionNetwork, chances: Chances, effort: Effort, start: State) -> Chain:
    """Return the chain of likely states, with the ends of a `RuleFlow` if that follows more states."""
    flows = can_flow(network)
    states = effort.part(LIKELY_SHARE) if flows else effort
    chain = policy_chain(likely_policy(network, chances, states, start), chances)
    if not flows:
        return chain
    try:
        flow = RuleFlow(network, chances, effort).result(start)
    except TooMuch:
        return chain
    return chain.with_flow(flow) if flow.ends.unknown.p < chain.ends.unknown.p else chain
