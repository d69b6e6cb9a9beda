"""Flow of probability through the rule's states, against the chain of every state."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.deciding.random_networks import ANY_BINDING, Drawn, drawn
from handcart.networks.analysis.forecast import Forecaster
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import State, explored, policy
from handcart.networks.chains.policy_chain import policy_chain
from handcart.networks.chains.rule_flow import RuleFlow, can_flow
from handcart.networks.graph.network import Action, ActionNetwork, FailEnding, Situation


def with_all_kinds(seed: int) -> Drawn:
    """Draw a small network with equal costs, skips, shared attempts and Fails that lead on by cause."""
    draws, names = random.Random(seed), "abcdz"
    actions = [Action(a, b, ANY_BINDING, draws.choice([1.0, 4.0]), 2) for a, b in ("ab", "bc", "cd", "dz")]
    for _ in range(5):
        source, target, fails = draws.choice("abcd"), draws.choice(names), draws.choice([*"abcd", None])
        binding = None if draws.random() < 0.2 else ANY_BINDING
        action = Action(source, target, binding, draws.choice([1.0, 2.0, 4.0]), draws.randint(1, 3), fails)
        if binding and draws.random() < 0.4:
            action = replace(action, budget=draws.choice(["one", "two"]), attempts=2)
        if binding and draws.random() < 0.3:
            action = replace(action, fail_endings=(FailEnding("blocked", draws.choice("abcd")),))
        actions.append(action)
    chances = [
        Chance(draws.choice([0.3, 0.6, 0.9]), draws.choice([0.0, 0.1])) if a.binding else None
        for a in actions
    ]
    return Drawn(ActionNetwork.build(map(Situation, names), actions, "a", "z"), chances)


@pytest.mark.parametrize(
    "task",
    [
        *(pytest.param(with_all_kinds(seed), id=f"all kinds {seed}") for seed in range(20)),
        *(pytest.param(drawn(family, 1, 8), id=family) for family in ("forward", "back", "anywhere")),
    ],
)
def test_flow_ends_as_the_chain_of_every_state(task: Drawn) -> None:
    start = State(task.network.start, ())
    chain = policy_chain(policy(task.network, chances=task.chances), task.chances)
    flow = RuleFlow(task.network, task.chances, Effort(1e6)).result(start, max_open=1e-10)
    for found, expected in zip(flow.ends, chain.ends, strict=True):
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-5)
    assert flow.starts == pytest.approx(chain.starts, abs=1e-7)
    assert flow.ended[:, 1:] == pytest.approx(chain.ended[:, 1:], abs=1e-7)
    assert flow.skips == pytest.approx(chain.skips, abs=1e-7)


def test_flow_out_of_budget_leaves_an_interval_around_the_value() -> None:
    task = drawn("anywhere", 1, 8)
    start = State(task.network.start, ())
    value = policy_chain(policy(task.network, chances=task.chances), task.chances).ends.goal.p
    ends = RuleFlow(task.network, task.chances, Effort(120.0)).result(start, max_open=1e-10).ends
    assert 1e-4 < ends.unknown.p < 1.0
    assert ends.goal.p <= value <= ends.goal.p + ends.unknown.p
    assert np.sum([end.p for end in ends]) == pytest.approx(1.0)


def test_rule_with_loops_is_known_to_a_thousandth() -> None:
    """Its states by likelihood leave 0.04 open with this budget."""
    task = drawn("back", 4)
    found = Forecaster(task.network, task.chances, Effort(3e5)).forecast()
    assert found.unknown < 1e-3
    assert found.goal <= 0.51367 <= found.goal_high  # by `plain_solver.rule_ends` in 20 s: 0.51362 to 0.51370


def with_dead_ends() -> Drawn:
    """Return a network whose one action fails for eight causes, each into a situation without a way."""
    names = [f"d{number}" for number in range(8)]
    endings = tuple(FailEnding(name, name) for name in names)
    action = Action("a", "z", ANY_BINDING, fail_endings=endings)
    return Drawn(ActionNetwork.build(map(Situation, ["a", *names, "z"]), [action], "a", "z"), [Chance(0.5)])


@pytest.mark.parametrize(
    "task",
    [
        *(pytest.param(with_all_kinds(seed), id=f"all kinds {seed}") for seed in range(20)),
        *(pytest.param(drawn(family, 1, 8), id=family) for family in ("forward", "back", "anywhere")),
        pytest.param(with_dead_ends(), id="dead ends"),
    ],
)
def test_least_steps_never_exceed_those_of_the_search(task: Drawn) -> None:
    start, effort = State(task.network.start, ()), Effort(1e6)
    assert explored(task.network, effort=effort, chances=task.chances).is_complete
    found = RuleFlow(task.network, task.chances, Effort(1e6)).least_steps(start, 1e6)
    assert found <= effort.spent
    assert found > 0.1 * effort.spent  # so that searches that cannot succeed are noticed


@pytest.mark.parametrize(("steps", "is_exact"), [(1.01, True), (0.99, False)])
def test_forecast_is_exact_if_the_budget_suffices_for_all_states(steps: float, is_exact: bool) -> None:
    task, needed = drawn("back", 3, 7), Effort(1e6)
    assert explored(task.network, effort=needed).is_complete
    # A quarter of a forecaster's budget is for the search of all states.
    forecaster = Forecaster(task.network, task.chances, Effort(4.0 * steps * needed.spent))
    assert (forecaster.forecast().unknown == 0.0) == is_exact


@pytest.mark.parametrize(
    "action", [Action("a", "z", ANY_BINDING, renewals=2), Action("a", "z", ANY_BINDING, unlimited=True)]
)
def test_states_without_more_fails_cannot_flow(action: Action) -> None:
    assert not can_flow(ActionNetwork.build(map(Situation, "az"), [action], "a", "z"))
