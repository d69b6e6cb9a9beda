"""The planner of a network's policy."""

from __future__ import annotations

from handcart.networks.chains.policy import Chances
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.planner import Planner

from .belief_planner import BeliefPlanner
from .best_planner import BestPlanner, chances_of
from .best_policy import BestPolicy, PolicyName


def planner_of(network: ActionNetwork, chances: Chances | None = None) -> Planner:
    """Return the object that chooses a run's actions by the policy that the network names.

    Args:
        network: the network.
        chances: outcome probabilities; None: those of its actions.
    """
    if network.policy == "rule":
        return Planner(network)
    known = chances_of(network) if chances is None else chances
    name: PolicyName = "goal_probability" if network.policy == "goal_probability" else "expected_cost"
    if network.belief is not None and chances is None:
        return BeliefPlanner(network, network.belief, name)
    return BestPlanner(BestPolicy(network, known, name, network.person_s))
