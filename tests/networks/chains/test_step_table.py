"""Values of all states of a rule from one solution, against a policy and a chain of each state."""

from __future__ import annotations

import pytest

from benchmarks.deciding.random_networks import Drawn, drawn
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import TooLarge, policy
from handcart.networks.chains.policy_chain import policy_chain, values_of_states
from handcart.networks.chains.step_maker import State
from handcart.networks.chains.step_table import StepTable
from handcart.networks.deciding.option_values import RunOptionValues
from tests.networks.chains.test_rule_flow import with_all_kinds


@pytest.mark.parametrize(
    "task",
    [
        *(pytest.param(with_all_kinds(seed), id=f"all kinds {seed}") for seed in (0, 7)),
        *(pytest.param(drawn(family, 1, 5), id=family) for family in ("back", "anywhere")),
    ],
)
def test_values_of_states_equal_the_chain_of_each(task: Drawn) -> None:
    network, chances = task.network, task.chances
    start = State(network.start, ())
    values = values_of_states(StepTable(network, chances).policy(start, Effort(1e6)), chances)
    assert len(values) > 1
    for state in list(values)[:: max(1, len(values) // 8)]:
        ends = policy_chain(policy(network, start=state, chances=chances), chances).ends
        assert values[state] == pytest.approx((ends.goal.p, ends.total().first), rel=1e-9, abs=1e-12)


def test_budget_is_that_of_a_policy_whatever_was_explored_before() -> None:
    task = drawn("anywhere", 1, 5)
    network, chances = task.network, task.chances
    start, spent = State(network.start, ()), Effort(1e6)
    policy(network, effort=spent, start=start, chances=chances)
    table = StepTable(network, chances)
    table.policy(start, Effort(spent.spent))
    with pytest.raises(TooLarge):
        table.policy(start, Effort(spent.spent - 1.0))


def test_figures_are_shared_while_beliefs_are_equal() -> None:
    task = drawn("back", 1, 5)
    shared = RunOptionValues(task.network)
    first = shared.by(list(task.chances), None)
    assert shared.by(list(task.chances), "rule") is first
    assert shared.by(list(task.chances), "expected_cost") is not first
    assert shared.by(None, None) is not first
