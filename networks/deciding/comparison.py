"""The rule and the best policy of a task side by side, with the decisions in which they differ."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handcart.networks.analysis.forecast import Forecaster
from handcart.networks.chains.chain_rows import ChainRows
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.linear_solver import LinearSolver
from handcart.networks.chains.policy import Chances, Policy
from handcart.networks.chains.step_maker import State, StepMaker
from handcart.networks.graph.network import Action, ActionNetwork

from .best_policy import BestPolicy, PolicyName
from .process import Process
from .run_figures import PolicyFigures, best_figures, rule_figures

MAX_DIFFERENCES = 10
NO_CHANCE = 1e-9
"""Share of runs that reach the goal below which no price of a person is named."""
MIN_SHARE = 1e-4
"""Share of runs that come to a decision, below which it is not listed."""


class PolicyDifference(NamedTuple):
    """State in which the rule and the best policy decide differently, with both decisions."""

    situation: str
    fails: str
    """Fails that count, in words; empty for none."""
    rule: str
    best: str
    share: float
    """Average number of times that a run of the best policy comes to the state."""


@dataclass(frozen=True)
class PolicyComparison:
    """Comparison of the rule (the cheapest route is taken) with the best policy, for one network."""

    rule: PolicyFigures
    best: PolicyFigures
    differences: tuple[PolicyDifference, ...]
    used: frozenset[int]
    """Numbers of the actions that runs of the best policy start."""
    low_s: float
    """Lower bound of the least price, in [s]; with `goal_probability` of no use."""
    follows_rule: bool = False
    """True if the search did not find anything better than the rule, which is then followed."""
    call_limit_s: float | None = None
    """Value of `person_s` above which the rule costs less than calling a person at once, in [s].

    None if the best policy does not call a person at the start.
    """

    @property
    def is_probability(self) -> bool:
        """True if "best policy" here means the policy with the largest probability to reach the goal."""
        return self.best.name == "goal_probability"

    def for_programs(self) -> dict[str, Any]:
        """Return the comparison as JSON values, which `handcart check --json` prints."""
        return {
            "rule": _plain(self.rule),
            "best": _plain(self.best),
            "differences": [difference._asdict() for difference in self.differences],
            "least_price_low_s": self.low_s,
            "follows_rule": self.follows_rule,
            "calls_person_at_start": self.call_limit_s is not None,
        }


def comparison(
    network: ActionNetwork,
    chances: Chances,
    name: PolicyName = "expected_cost",
    forecaster: Forecaster | None = None,
) -> PolicyComparison:
    """Compare the best policy with the rule, which always starts the first action of the cheapest plan to the
    goal.

    Args:
        network: the network.
        chances: outcome probabilities of each action; None for a skip, which leaves an element of a `repeat`
            undone.
        name: quantity for which the policy is best, `expected_cost` or `goal_probability`.
        forecaster: forecaster of the same network; None: a new one.
    """
    best = BestPolicy(network, chances, name, network.person_s)
    first = best.decision(State(network.start, ()))
    policy = best.policy()
    process = Process(network, chances, network.person_s)
    forecaster = forecaster or Forecaster(network, chances)
    rule = rule_figures(process, forecaster)
    if best.is_rule_better(forecaster):
        return PolicyComparison(rule, rule._replace(name=name), (), frozenset(), first.low, True)
    rows = ChainRows(policy, chances)
    visits = _visits(rows, policy)
    used = frozenset(
        action
        for action, often in zip(rows.action.tolist(), visits, strict=True)
        if often > 0.0 and action >= 0
    )
    differences = tuple(_differences(policy, visits, chances))
    figures = best_figures(process, policy, name)
    limit = _call_limit(process, rule) if first.action is None else None
    return PolicyComparison(rule, figures, differences, used, first.low, call_limit_s=limit)


def _call_limit(process: Process, rule: PolicyFigures) -> float:
    """Return the price of a person above which the rule costs less than calling one at the start."""
    stop = process.stop_price(process.network.start) / process.person_s
    ends = (rule.price_s[1] - rule.mean_s[1]) / process.person_s
    return rule.mean_s[1] / (stop - ends) if stop - ends > NO_CHANCE else math.inf


def _visits(rows: ChainRows, policy: Policy) -> Sequence[float]:
    """Return how often a run comes to each row, on average."""
    if rows.start < 0:
        return []
    begins = np.zeros(len(rows.action))
    begins[rows.start] = 1.0
    links = rows.succeeds.joined(rows.fails, rows.skips)
    found: list[float] = LinearSolver(len(begins), links, policy.circles).solve(begins, True).tolist()
    return found


def _differences(policy: Policy, visits: Sequence[float], chances: Chances) -> list[PolicyDifference]:
    network = policy.network
    maker = StepMaker(network, False, Effort(float("inf")), chances)
    often = sorted(zip(visits, policy.steps.items(), strict=True), key=lambda item: -item[0])
    found: list[PolicyDifference] = []
    for share, (state, step) in often:
        if share < MIN_SHARE or len(found) == MAX_DIFFERENCES:
            break
        rule = maker.step(state)
        if (rule.action and rule.action.index) != (step.action and step.action.index):
            words = _decision_words(rule.action), _decision_words(step.action)
            if step.person:
                words = words[0], "calling a person"
            found.append(PolicyDifference(state.situation, _fails_words(network, state), *words, share))
    return found


def _decision_words(action: Action | None) -> str:
    """Return an action with its cost."""
    return "nothing" if action is None else f"{action}, {action.cost_s:g} s"


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
