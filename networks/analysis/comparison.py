"""The rule and the best policy of a task side by side, with the decisions in which they differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handcart.networks.chains.chain_rows import ChainRows
from handcart.networks.chains.chain_times import Quantile, time_quantile
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.ends import Ends
from handcart.networks.chains.linear_solver import LinearSolver
from handcart.networks.chains.policy import Chances, Policy, explored, likely_policy
from handcart.networks.chains.policy_chain import policy_chain
from handcart.networks.chains.step_maker import State, StepMaker
from handcart.networks.deciding.best_policy import BestPolicy, PolicyName
from handcart.networks.graph.network import ActionNetwork

RULE_STEPS = 200_000
"""Budget of the rule's states: one second."""
MAX_DIFFERENCES = 10
MIN_SHARE = 1e-4
"""Share of runs that come to a decision, below which it is not listed."""


class PolicyFigures(NamedTuple):
    """What runs of a policy come to; each is an interval if some states were not looked at."""

    name: str
    goal: tuple[float, float]
    """Probability that the goal is reached with nothing left undone."""
    mean_s: tuple[float, float]
    """Expected time of a run, in [s]."""
    time_95_s: Quantile
    """Time within which 95 % of the runs end, in [s]."""
    price_s: tuple[float, float]
    """Expected time, with `person_s` for each end short of the goal, in [s]."""


class Difference(NamedTuple):
    """A state in which the policies decide differently."""

    situation: str
    fails: str
    """Fails that count, in words; empty for none."""
    rule: str
    best: str
    share: float
    """Average number of times that a run of the best policy comes to it."""


@dataclass(frozen=True)
class Comparison:
    """The rule and the best policy side by side."""

    rule: PolicyFigures
    best: PolicyFigures
    differences: tuple[Difference, ...]
    used: frozenset[int]
    """Numbers of the actions that runs of the best policy start."""
    low_s: float
    """Lower bound of the least price, in [s]; with `goal_probability` of no use."""

    def for_programs(self) -> dict[str, Any]:
        """Return the comparison as `handcart check --json` prints it."""
        return {
            "rule": _plain(self.rule),
            "best": _plain(self.best),
            "differences": [each._asdict() for each in self.differences],
            "least_price_low_s": self.low_s,
        }


def comparison(network: ActionNetwork, chances: Chances, name: PolicyName = "expected_cost") -> Comparison:
    """Compare the rule with the best policy.

    Args:
        network: the network.
        chances: outcome probabilities of each action; None for a skip.
        name: what is best: `expected_cost` or `goal_probability`.
    """
    start = State(network.start, ())
    rule = explored(network, effort=Effort(RULE_STEPS), chances=chances)
    if not rule.is_complete:
        rule = likely_policy(network, chances, Effort(RULE_STEPS), start)
    best = BestPolicy(network, chances, name, network.person_s)
    low = best.decision(start).low
    policy = best.policy()
    rows = ChainRows(policy, chances)
    visits = _visits(rows, policy)
    used = frozenset(
        action for action, often in zip(rows.action, visits, strict=True) if often > 0.0 and action >= 0
    )
    return Comparison(
        _figures("rule", rule, chances),
        _figures(best.name, policy, chances),
        tuple(_differences(policy, visits, chances)),
        used,
        low,
    )


def _figures(name: str, policy: Policy, chances: Chances) -> PolicyFigures:
    ends = policy_chain(policy, chances).ends
    person, unknown = policy.network.person_s, ends.unknown.p
    mean = ends.total().first
    dearest = max((a.cost_s for a in policy.network.actions), default=0.0)
    more = unknown * policy.network.bound() * dearest if unknown else 0.0
    short = _short(ends)
    quantile = time_quantile(ChainRows(policy, chances))
    price = mean + person * short, mean + more + person * (short + unknown)
    goal = ends.goal.p, min(1.0, ends.goal.p + unknown)
    return PolicyFigures(name, goal, (mean, mean + more), quantile, price)


def _short(ends: Ends) -> float:
    return ends.skipped.p + ends.no_way.p + ends.give_up.p


def _visits(rows: ChainRows, policy: Policy) -> Sequence[float]:
    """Return how often a run comes to each row, on average."""
    if rows.start < 0:
        return []
    begins = np.zeros(len(rows.action))
    begins[rows.start] = 1.0
    links = [*rows.succeeds, *rows.fails, *rows.skips]
    found: list[float] = LinearSolver(len(begins), links, policy.circles).solve(begins, True).tolist()
    return found


def _differences(policy: Policy, visits: Sequence[float], chances: Chances) -> list[Difference]:
    network = policy.network
    maker = StepMaker(network, False, Effort(float("inf")), chances)
    often = sorted(zip(visits, policy.steps.items(), strict=True), key=lambda each: -each[0])
    found: list[Difference] = []
    for share, (state, step) in often:
        if share < MIN_SHARE or len(found) == MAX_DIFFERENCES:
            break
        rule = maker.step(state)
        if (rule.action and rule.action.index) != (step.action and step.action.index):
            best = "calling a person" if step.person else str(step.action or "nothing")
            fails = _fails_words(network, state)
            found.append(Difference(state.situation, fails, str(rule.action or "nothing"), best, share))
    return found


def _fails_words(network: ActionNetwork, state: State) -> str:
    """Return the Fails that count in a state, in words."""
    counted = []
    for counter, count in state.fails:
        action = network.actions[counter]
        fails = action.allowance.fails(count)
        if fails:
            counted.append(f"{action} failed {fails} time{'s' * (fails > 1)}")
    return ", ".join(counted)


def _plain(figures: PolicyFigures) -> dict[str, Any]:
    return {
        "policy": figures.name,
        "p_goal": figures.goal[0],
        "p_goal_high": figures.goal[1],
        "mean_s": figures.mean_s[0],
        "mean_high_s": figures.mean_s[1],
        "time_95_s": figures.time_95_s.low_s,
        "time_95_high_s": figures.time_95_s.high_s,
        "price_s": figures.price_s[0],
        "price_high_s": figures.price_s[1],
    }
