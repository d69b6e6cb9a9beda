"""Prices of policies for many draws at once, against the chain of each draw."""

from __future__ import annotations

import random

import numpy as np
import pytest

from benchmarks.deciding.random_networks import ANY_BINDING, drawn
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import Chances, State, explored, likely_policy
from handcart.networks.deciding.best_policy import BestPolicy
from handcart.networks.deciding.drawn_prices import DrawnPrices
from handcart.networks.deciding.process import Process
from handcart.networks.deciding.run_figures import best_figures
from handcart.networks.graph.network import Action, ActionNetwork, FailEnding, Situation


def draws_of(count: int, seed: int) -> list[Chances]:
    """Draw probabilities of Success and GiveUp of some actions, three times."""
    draws = random.Random(seed)
    return [
        [Chance(draws.uniform(0.3, 0.9), draws.uniform(0.0, 0.1)) for _ in range(count)] for _ in range(3)
    ]


@pytest.mark.parametrize("family", ["forward", "back", "anywhere"])
@pytest.mark.parametrize("seed", [0, 1, 3])
def test_prices_equal_those_of_the_chain_of_each_draw(family: str, seed: int) -> None:
    network, chances = drawn(family, seed, 7)
    begin, process = State(network.start, ()), Process(network, chances, 600.0)
    draws = draws_of(len(network.actions), seed)
    prices = DrawnPrices(process, draws)
    best = BestPolicy(network, chances, "expected_cost", 600.0, Effort(2e4))
    for policy in (
        best.policy(),
        explored(network, effort=Effort(2e3)),
        likely_policy(network, chances, Effort(500.0), begin),
    ):
        found = prices.of(policy)
        for price, draw in zip(found.tolist(), draws, strict=True):
            own = best_figures(process.believing(draw), policy, "own", walks=False)
            assert price == pytest.approx(own.price_s[1], rel=1e-9)


def test_policy_that_never_ends_has_a_very_large_price() -> None:
    actions = [
        Action("a", "b", ANY_BINDING),
        Action("b", "a", ANY_BINDING),
        Action("b", "z", ANY_BINDING, 1e4),
    ]
    network = ActionNetwork.build(map(Situation, "abz"), actions, "a", "z")
    process = Process(network, [Chance(1.0)] * 3, 600.0)
    circle = {
        State(name, ()): process.step(State(name, ()), action)
        for name, action in zip("ab", actions[:2], strict=True)
    }
    policy = likely_policy(network, [Chance(1.0)] * 3, Effort(1e3), State("a", ()))
    policy = type(policy)(network, policy.start, circle, circles=True)
    found = DrawnPrices(process, [[Chance(1.0)] * 3]).of(policy)
    assert np.all(found > 1e9)


def test_draws_with_shares_of_their_own_have_prices_of_their_own() -> None:
    first = Action("a", "z", ANY_BINDING, 1.0, 1, fail_endings=(FailEnding("blocked", "b"),))
    actions = [first, Action("b", "z", ANY_BINDING, 100.0, 1)]
    network = ActionNetwork.build(map(Situation, "abz"), actions, "a", "z")
    draws = [[Chance(0.5, 0.0, (1.0 - share, share)), Chance(1.0)] for share in (0.2, 0.6)]
    policy = explored(network, effort=Effort(1e3))
    found = DrawnPrices(Process(network, draws[0], 600.0), draws).of(policy)
    assert found == pytest.approx(
        [1.0 + 0.5 * (share * 100.0 + (1.0 - share) * 600.0) for share in (0.2, 0.6)]
    )
