"""Order in which the states of a policy are visited."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.deciding.random_networks import drawn
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import Policy, explored
from handcart.networks.graph.network import ActionNetwork


def _returns(policy: Policy) -> bool:
    """Return whether some state follows itself, by removing states of which all successors are removed."""
    left = {
        state: {item for item in step.following() if item in policy.steps}
        for state, step in policy.steps.items()
    }
    while ends := [state for state, after in left.items() if not after & left.keys()]:
        for state in ends:
            del left[state]
    return bool(left)


@pytest.mark.parametrize("unlimited", [False, True])
@pytest.mark.parametrize("family", ["forward", "back", "anywhere"])
@pytest.mark.parametrize("seed", range(4))
def test_successors_come_first_unless_runs_go_in_circles(family: str, seed: int, unlimited: bool) -> None:
    network = drawn(family, seed, 7).network
    actions = [
        replace(action, unlimited=unlimited and not number, index=-1)
        for number, action in enumerate(network.actions)
    ]
    network = ActionNetwork.build(network.situations.values(), actions, network.start, network.goal)
    policy = explored(network, effort=Effort(1e6))
    assert policy.is_complete
    assert policy.circles == _returns(policy)
    assert family != "forward" or policy.circles == unlimited
    number = {state: place for place, state in enumerate(policy.steps)}
    if not policy.circles:
        assert all(
            number[item] < place
            for (state, step), place in zip(policy.steps.items(), number.values(), strict=True)
            for item in step.following()
            if item in number
        )
