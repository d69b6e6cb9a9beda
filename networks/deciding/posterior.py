"""Probabilities of an action by counted outcomes, and whether they suffice to leave the rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import Chances, Policy, likely_policy
from handcart.networks.chains.step_maker import State
from handcart.networks.graph.network import ActionNetwork

from .best_policy import BestPolicy, PolicyName
from .drawn_prices import DrawnPrices

PRIOR_SUCCESS, PRIOR_FAIL, PRIOR_GIVE_UP = 1.0, 1.0, 0.1
"""Weights of the prior, as outcomes seen before: any probability of Success is as likely as another, and
GiveUps are rare.
"""
DRAW_COUNT = 200
SURE_SHARE = 0.95
"""Share of draws in which a policy has to be better than the rule to be chosen."""
MIN_SAVING = 1e-4
"""Share of the rule's price above which a lower price is better, not rounded differently."""
RULE_STEPS = 100_000.0
"""Budget of the rule's states."""


class OutcomeCounts(NamedTuple):
    """Numbers of attempts of an action that ended in Success, Fail and GiveUp."""

    successes: int = 0
    fails: int = 0
    give_ups: int = 0
    by_cause: tuple[int, ...] = ()
    """Number of Fails of each cause in `Action.fail_endings`; empty: the shares of the file hold."""
    by_result: tuple[int, ...] = ()
    """Number of Successes of each result, the usual one first; empty: the shares of the file hold."""

    @property
    def attempts(self) -> int:
        """Number of all attempts of the action."""
        return self.successes + self.fails + self.give_ups

    @property
    def weights(self) -> tuple[float, float, float]:
        """Parameters of the Dirichlet distribution of an action's chances of Success, Fail and GiveUp.

        Each is the count of the outcome plus the outcome's prior weight.
        """
        prior = PRIOR_SUCCESS, PRIOR_FAIL, PRIOR_GIVE_UP
        return prior[0] + self.successes, prior[1] + self.fails, prior[2] + self.give_ups

    @property
    def chance(self) -> Chance:
        """Expected probabilities of Success, Fail and GiveUp, given the counted outcomes."""
        success, fail, give_up = self.weights
        total = success + fail + give_up
        shares = self.fail_weights, self.result_weights
        fails, results = (tuple(w / sum(weights) for w in weights) for weights in shares)
        return Chance(success / total, give_up / total, fails, results)

    @property
    def fail_weights(self) -> tuple[float, ...]:
        """Parameters of the Dirichlet distribution of a Fail's causes; the first is for all unnamed causes
        together.

        Each parameter is the count of its cause plus an equal part of the prior weight of Fail. Their sum is
        the weight of Fail in `weights`. The tuple is empty if no causes are counted.
        """
        if not self.by_cause:
            return ()
        prior = PRIOR_FAIL / (1 + len(self.by_cause))
        return (prior + self.fails - sum(self.by_cause), *(prior + count for count in self.by_cause))

    @property
    def result_weights(self) -> tuple[float, ...]:
        """Weights of the results that a Success may have, the parameters of their Dirichlet distribution.

        The first weight is for the result that leads to `Action.target`. A weight is the result's count plus
        its share of the prior.
        """
        return tuple(PRIOR_SUCCESS / len(self.by_result) + count for count in self.by_result)


class SwitchVerdict(NamedTuple):
    """Comparison of the best policy with the rule, for many random draws of the actions' outcome
    probabilities.

    The rule always takes the cheapest route to the goal; a switch is from the rule to the best policy. The
    draws are from the posterior distribution given the outcomes counted so far.
    """

    better_share: float
    """Share of draws in which the best policy costs less than the rule."""
    saved_s: float
    """Cost that the best policy saves, in [s], in the mean of all draws."""
    is_same: bool
    """True if both policies decide alike in all states that runs reach."""

    @property
    def is_sure(self) -> bool:
        """True if the best policy costs less than the rule (the cheapest route is taken) in almost all draws.

        That is at least the share `SURE_SHARE` of the drawn outcome probabilities.
        """
        return not self.is_same and self.better_share >= SURE_SHARE


def judge_switch(
    network: ActionNetwork,
    counts: Sequence[OutcomeCounts | None],
    name: PolicyName = "expected_cost",
    person_s: float = 600.0,
    seed: int = 0,
) -> SwitchVerdict:
    """Judge by counted outcomes whether the best policy costs less than the rule.

    The best policy is that for the mean outcome probabilities; the rule takes the cheapest route.

    Args:
        network: the network.
        counts: counted outcomes of each action; None if it only skips an element of a list over which the
            task repeats actions. The copies of an action for these elements share one object.
        name: the policy to compare, `expected_cost` or `goal_probability`.
        person_s: price of an end short of the goal, in [s].
        seed: seed of the draws.
    """
    mean: list[Chance | None] = [None if count is None else count.chance for count in counts]
    best = BestPolicy(network, mean, name, person_s)
    if best.is_rule_better():
        return SwitchVerdict(0.0, 0.0, True)
    return judge_policies(best, lambda: _drawn(counts, seed), State(network.start, ()), RULE_STEPS)


def judge_policies(
    best: BestPolicy, draw: Callable[[], Sequence[Chances]], start: State, rule_steps: float
) -> SwitchVerdict:
    """Judge by draws of the outcome probabilities whether a best policy costs less than a simple rule.

    The rule always takes the cheapest route to the goal.

    Args:
        best: the best policy for the mean outcome probabilities.
        draw: function that returns draws of all outcome probabilities; not called if both policies decide
            alike in all states.
        start: state in which the compared runs begin.
        rule_steps: budget for computing the rule's decisions, in steps of `Effort`.
    """
    chosen = best.policy(start)
    rule = likely_policy(best.network, best.process.chances, Effort(rule_steps), start)
    if _decide_alike(chosen, rule):
        return SwitchVerdict(0.0, 0.0, True)
    prices = DrawnPrices(best.process, draw())
    by_rule = prices.of(rule)
    saved = by_rule - prices.of(chosen)
    return SwitchVerdict(float(np.mean(saved > MIN_SAVING * by_rule)), float(np.mean(saved)), False)


def _decide_alike(one: Policy, other: Policy) -> bool:
    """Return whether two policies decide alike in all states that the first comes to."""
    pairs = ((step, other.steps.get(state)) for state, step in one.steps.items())
    return all(theirs is not None and step.action == theirs.action for step, theirs in pairs)


def _drawn(counts: Sequence[OutcomeCounts | None], seed: int) -> list[list[Chance | None]]:
    """Return draws of all probabilities from the posterior."""
    draws = np.random.default_rng([29, seed])
    unique = {id(count): count for count in counts if count is not None}
    rows = {key: _chances(item, draws) for key, item in unique.items()}
    return [
        [None if count is None else rows[id(count)][number] for count in counts]
        for number in range(DRAW_COUNT)
    ]


def _chances(counts: OutcomeCounts, draws: np.random.Generator) -> list[Chance]:
    """Return draws of one action's probabilities."""
    ends = draws.dirichlet(counts.weights, DRAW_COUNT).tolist()
    fails, results = (
        map(tuple, draws.dirichlet(weights, DRAW_COUNT).tolist() if weights else [()] * DRAW_COUNT)
        for weights in (counts.fail_weights, counts.result_weights)
    )
    rows = zip(ends, fails, results, strict=True)
    return [Chance(success, give_up, *shares) for (success, _, give_up), *shares in rows]
