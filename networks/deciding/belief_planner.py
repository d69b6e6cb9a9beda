"""Planner that leaves the rule where the beliefs of the run say that another policy is better."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from typing_extensions import override

from handcart.networks.chains.effort import Effort
from handcart.networks.chains.step_maker import State, Step
from handcart.networks.graph.belief_prior import BeliefPrior, Judged
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.graph.planner import NoWay, Plan

from .beliefs import Beliefs
from .best_planner import BestPlanner
from .best_policy import BestPolicy, PolicyName
from .posterior import SwitchVerdict, judge_policies

BEST_STEPS, RULE_STEPS = 60_000.0, 20_000.0
"""Budgets of one judgement, for the best policy and for the rule, in steps; some 0.3 s."""


class BeliefPlanner(BestPlanner):
    """Planner that learns outcome probabilities during a run, and with them chooses between two policies.

    Beliefs are distributions of the probabilities, updated by each Success and Fail and kept from round to
    round. For each plan, probabilities are drawn from them many times. The best policy of the task's file is
    followed if it costs less than the rule in 95 % of the draws. Otherwise the rule is followed, which takes
    the cheapest route.
    """

    def __init__(self, network: ActionNetwork, prior: BeliefPrior, name: PolicyName) -> None:
        """Create a planner of a network in which nothing has been tried.

        Args:
            network: the network.
            prior: the beliefs at first.
            name: the policy that is followed where it is better.
        """
        self.beliefs = Beliefs(network, prior)
        chances = self.beliefs.chances()
        super().__init__(BestPolicy(network, chances, name, network.person_s, Effort(BEST_STEPS)))
        self._is_new = False

    @override
    def failed(self, action: Action, reason: str, *, permanent: bool = False) -> None:
        super().failed(action, reason, permanent=permanent)
        self._is_new |= self.beliefs.failed(action)

    @override
    def succeeded(self, action: Action) -> bool:
        self._is_new |= self.beliefs.succeeded(action)
        return super().succeeded(action)

    @override
    def plan(self, situation: str, goal: str | None = None, without: Iterable[Action] = ()) -> Plan | NoWay:
        excluded = list(without)
        if goal not in (None, self.network.goal) or excluded or situation == self.network.goal:
            return self.plan_by_rule(situation, goal, excluded)
        verdict = self.verdict(situation)
        plan = self.plan_by_policy(situation) if verdict.is_sure else self.plan_by_rule(situation)
        name = self.best.name if verdict.is_sure else "rule"
        judged = Judged(name, verdict.better_share, verdict.saved_s, self.beliefs.changed)
        return replace(plan, judged=judged)

    @override
    def step(self, state: State) -> Step:
        return self.best.known_step(state) or self.best.step(state)

    def verdict(self, situation: str) -> SwitchVerdict:
        """Return how much cheaper the rest of the run is expected to be by the best policy than by the rule.

        The rule always starts the first action of the cheapest plan to the goal. The expected costs are
        computed with the present beliefs about the outcome probabilities.

        Args:
            situation: the run's present situation.
        """
        if self._is_new:
            self.best = self.best.believing(self.beliefs.chances(), Effort(BEST_STEPS))
            self._is_new = False
        start = self.best.state(situation, self.counts)
        return judge_policies(self.best, self.beliefs.drawn, start, RULE_STEPS)
