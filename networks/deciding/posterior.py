"""Probabilities of an action by counted outcomes, and whether they suffice to leave the rule."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import Chances, Policy, explored, likely_policy
from handcart.networks.chains.step_maker import State
from handcart.networks.graph.network import ActionNetwork

from .best_policy import BestPolicy, PolicyName
from .process import Process
from .run_figures import best_figures

PRIOR_SUCCESS, PRIOR_FAIL, PRIOR_GIVE_UP = 1.0, 1.0, 0.1
"""Weights of the prior, as outcomes seen before: any probability of Success is as likely as another, and
GiveUps are rare.
"""
DRAW_COUNT = 200
SURE_SHARE = 0.95
"""Share of draws in which a policy has to be better than the rule to be chosen."""
RULE_STEPS = 100_000.0
"""Budget of the rule's states."""


class OutcomeCounts(NamedTuple):
    """Numbers of attempts of an action that ended in Success, Fail and GiveUp."""

    successes: int = 0
    fails: int = 0
    give_ups: int = 0

    @property
    def attempts(self) -> int:
        """Number of all attempts of the action."""
        return self.successes + self.fails + self.give_ups

    @property
    def weights(self) -> tuple[float, float, float]:
        """Parameters of the Dirichlet distribution of Success, Fail and GiveUp."""
        prior = PRIOR_SUCCESS, PRIOR_FAIL, PRIOR_GIVE_UP
        return prior[0] + self.successes, prior[1] + self.fails, prior[2] + self.give_ups

    @property
    def chance(self) -> Chance:
        """Expected probabilities of the three outcomes."""
        success, fail, give_up = self.weights
        total = success + fail + give_up
        return Chance(success / total, give_up / total)


class SwitchVerdict(NamedTuple):
    """Comparison of the best policy with the rule over the posterior."""

    better_share: float
    """Share of draws in which the best policy costs less than the rule."""
    saved_s: float
    """Cost that it saves, in [s], in the mean of all draws."""
    is_same: bool
    """True if both decide alike wherever runs come."""

    @property
    def is_sure(self) -> bool:
        """True if the best policy is better in enough draws."""
        return not self.is_same and self.better_share >= SURE_SHARE


def judge_switch(
    network: ActionNetwork,
    counts: Sequence[OutcomeCounts | None],
    name: PolicyName = "expected_cost",
    person_s: float = 600.0,
    seed: int = 0,
) -> SwitchVerdict:
    """Judge whether the best policy of the expected probabilities is better than the rule.

    Args:
        network: the network.
        counts: outcomes of each action; None for a skip. Copies of one action share one object.
        name: what is best.
        person_s: price of an end short of the goal, in [s].
        seed: seed of the draws.
    """
    mean: list[Chance | None] = [None if each is None else each.chance for each in counts]
    best = BestPolicy(network, mean, name, person_s)
    chosen, rule = best.policy(), _rule(network, mean)
    if best.is_rule_better() or _decide_alike(chosen, rule):
        return SwitchVerdict(0.0, 0.0, True)
    price = best.process.person_s
    saved = [_price(rule, drawn, price) - _price(chosen, drawn, price) for drawn in _drawn(counts, seed)]
    return SwitchVerdict(float(np.mean(np.array(saved) > 0.0)), float(np.mean(saved)), False)


def _rule(network: ActionNetwork, chances: Chances) -> Policy:
    found = explored(network, effort=Effort(RULE_STEPS), chances=chances)
    if found.is_complete:
        return found
    return likely_policy(network, chances, Effort(RULE_STEPS), State(network.start, ()))


def _decide_alike(one: Policy, other: Policy) -> bool:
    """Return whether two policies decide alike in all states that the first comes to."""
    pairs = ((step, other.steps.get(state)) for state, step in one.steps.items())
    return all(theirs is not None and step.action == theirs.action for step, theirs in pairs)


def _price(policy: Policy, chances: Chances, person_s: float) -> float:
    process = Process(policy.network, chances, person_s)
    return best_figures(process, policy, "", walks=False).price_s[0]


def _drawn(counts: Sequence[OutcomeCounts | None], seed: int) -> list[list[Chance | None]]:
    """Return draws of all probabilities from the posterior."""
    draws = np.random.default_rng([29, seed])
    unique = {id(each): each for each in counts if each is not None}
    rows = {key: draws.dirichlet(each.weights, DRAW_COUNT) for key, each in unique.items()}

    def chance(each: OutcomeCounts | None, number: int) -> Chance | None:
        if each is None:
            return None
        success, _, give_up = rows[id(each)][number].tolist()
        return Chance(success, give_up)

    return [[chance(each, number) for each in counts] for number in range(DRAW_COUNT)]
