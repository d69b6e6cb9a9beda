"""Options of newly expanded states, and the search that follows them for several levels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.deciding.random_networks import drawn
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.step_maker import State
from handcart.networks.deciding import component_search
from handcart.networks.deciding.best_policy import BestPolicy
from handcart.networks.deciding.situation_values import SituationValues
from handcart.networks.deciding.state_rows import StateRows
from handcart.networks.deciding.state_table import STOP_CHOICE, StateTable
from handcart.networks.graph.network import ActionNetwork


@pytest.mark.parametrize("seed", range(6))
def test_expanding_returns_the_options_that_cost_least(seed: int) -> None:
    task = drawn("anywhere", seed)
    process = BestPolicy(task.network, task.chances, "expected_cost", 600.0, Effort(1e5)).process
    parts = [part for part, names in enumerate(process.parts) if task.network.goal not in names]
    part = max(parts, key=lambda number: len(process.parts[number]))
    rows = StateRows(process, part, ())
    table = StateTable(rows, SituationValues(process), part)
    ahead = table.add(rows.row(State(process.parts[part][0], ())))
    for _ in range(5):
        options = table.expand(ahead)
        best = table.choices(table.low)
        assert np.array_equal(options == STOP_CHOICE, best.option[ahead] == STOP_CHOICE)
        acting = options != STOP_CHOICE
        follows, to, p = table.after(options)
        cost = table.prices(ahead, options) + np.bincount(follows, p * table.low[to], len(ahead))
        assert cost[acting] == pytest.approx(best.cost[ahead][acting], rel=1e-9)
        ahead = np.flatnonzero(~table.expanded & (table.states[:, 0] < rows.inside))[::-1]


@pytest.mark.slow
@pytest.mark.parametrize(("family", "seed"), [("back", 38), ("back", 32), ("anywhere", 38)])
def test_levels_of_a_round_change_no_value(family: str, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    task, found = drawn(family, seed), []
    for levels in (1, component_search.MAX_ROUND_LEVELS):
        monkeypatch.setattr(component_search, "MAX_ROUND_LEVELS", levels)
        best = BestPolicy(task.network, task.chances, "expected_cost", 600.0, Effort(2e5))
        found.append(best.decision(State(task.network.start, ())))
    one, several = found
    assert one.low <= several.cost * (1.0 + 1e-9)
    assert several.low <= one.cost * (1.0 + 1e-9)
    assert several.cost - several.low < 8e-4 * several.cost


@pytest.mark.parametrize("unlimited", [False, True])
def test_sweeps_are_steps_to_the_least_expected_cost(unlimited: bool) -> None:
    """With unlimited attempts, a Fail may leave the state as it is."""
    task = drawn("anywhere", 5)
    network = task.network
    actions = [replace(action, unlimited=unlimited, index=-1) for action in network.actions]
    network = ActionNetwork.build(network.situations.values(), actions, network.start, network.goal)
    process = BestPolicy(network, task.chances, "expected_cost", 600.0, Effort(1e5)).process
    part = max(range(len(process.parts)), key=lambda number: len(process.parts[number]))
    rows = StateRows(process, part, ())
    table = StateTable(rows, SituationValues(process), part)
    ahead = table.add(rows.row(State(process.parts[part][0], ())))
    for _ in range(4):
        table.expand(ahead)
        ahead = np.flatnonzero(~table.expanded & (table.states[:, 0] < rows.inside))
    table.high[table.states[:, 0] >= rows.inside] = 50.0  # known values beyond the component
    low, high = table.low.copy(), table.high.copy()
    for _ in range(3):
        low = np.fmax(low, np.where(table.expanded, table.choices(low).cost, low))
        high = np.fmin(high, table.choices(high).cost)
    table.raise_low(3)
    table.reduce_high(3)
    assert table.low == pytest.approx(low, rel=1e-12)
    assert table.high == pytest.approx(high, rel=1e-12)
    assert (table.high < table.stop)[table.expanded].any()
