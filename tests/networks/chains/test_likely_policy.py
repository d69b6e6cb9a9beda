"""Decisions in the likeliest states, as many as a budget allows."""

from __future__ import annotations

import itertools

import pytest

from benchmarks.deciding.random_networks import ANY_BINDING
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import explored, likely_policy
from handcart.networks.chains.step_maker import State
from handcart.networks.graph.network import Action, ActionNetwork, Situation


@pytest.mark.parametrize("steps", [1000.0, 2000.0, 3000.0])
def test_likely_policy_whose_budget_is_spent_is_incomplete(steps: float) -> None:
    """Also where only one state waited for its decision when the budget was spent."""
    names = [f"s{number}" for number in range(400)]
    actions = [Action(*pair, ANY_BINDING) for pair in itertools.pairwise(names)]
    network = ActionNetwork.build(map(Situation, names), actions, names[0], names[-1])
    chances = [Chance(1.0)] * len(actions)
    begin = State(names[0], ())
    found = likely_policy(network, chances, Effort(steps), begin)
    assert 0 < len(found.steps) < len(actions)
    assert not found.is_complete
    whole = likely_policy(network, chances, Effort(1e6), begin)
    assert whole.is_complete
    assert whole.steps == explored(network, chances=chances).steps
