"""What `check` knows of a network before anything moves."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from handcart.files.models.loading import load_document
from handcart.files.yaml.yaml_document import read_document
from handcart.networks.analysis.action_table import (
    ActionTable,
    table_absorption,
    table_errors,
    table_warnings,
)
from handcart.networks.analysis.forecast import forecast
from handcart.networks.chains.absorbing_chain import NeverEnds, absorption
from handcart.networks.chains.chance import Chance
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.graph.planner import NoWay
from handcart.networks.graph.route import RunDecisions
from handcart.primitives.driving.modify import Modify
from handcart.primitives.outcomes.outcome import Success

TABLE = Path(__file__).resolve().parents[3] / "tasks" / "return_book" / "paper_table.yaml"
BOUND = Binding.of(Modify(place="x"))


def network(
    *rows: tuple[str, str, float, int, str | None], start: str = "a", goal: str = "z"
) -> ActionNetwork:
    actions = [Action(s, t, BOUND, c, n, f) for s, t, c, n, f in rows]
    names = sorted({name for s, t, _, _, f in rows for name in (s, t, f) if name} | {start, goal})
    return ActionNetwork.build([Situation(name) for name in names], actions, start, goal)


@pytest.mark.parametrize(
    ("p", "goal", "give_up", "row_13"),
    [(0.9, 0.78053, 0.19000, 0.02947), (0.8, 0.53110, 0.36000, 0.10890), (0.99, 0.97980, 0.01990, 0.00030)],
)
def test_table_1_of_the_paper_has_its_known_answers(
    p: float, goal: float, give_up: float, row_13: float
) -> None:
    table = load_document(read_document(TABLE), ActionTable).value
    found = table_absorption(table, p)
    assert found.ends == pytest.approx({"GOAL": goal, "GIVEUP": give_up, "row 13": row_13}, abs=5e-6)
    if p == 0.9:
        assert (found.steps, found.steps_sigma) == pytest.approx((7.0224, 3.3231), abs=5e-5)


def test_all_defects_of_table_1_are_named_with_their_places() -> None:
    loaded = load_document(read_document(TABLE), ActionTable)
    findings = [*table_errors(loaded), *table_warnings(loaded)]
    found = {(finding.line, finding.message.split(";")[0]) for finding in findings}
    lines = {number: 7 + count for count, number in enumerate(loaded.value.rows, start=1)}
    named = {
        (lines[1], "Fail of row 1 leads to GIVEUP"),
        (lines[2], "Fail of row 2 leads to GIVEUP"),
        (lines[4], "Fail of row 4 leads to row 10, where other facts hold"),
        (lines[5], "Fail of row 5 leads to row 4, where other facts hold"),
        (lines[6], "Fail of row 6 leads to row 4, where other facts hold"),
        (lines[11], "row 11 leads to row 13, which is missing"),
        (lines[12], "Fail of row 12 leads to row 11, where other facts hold"),
        (6, "RELEASE is required and has no row"),
        (lines[3], "a loop without a bound: 3 to 10 to 3"),
        (lines[3], "a loop without a bound: 3 to 4 to 10 to 3"),
        (lines[4], "a loop without a bound: 4 to 5 to 6 to 4"),
        (lines[7], "a loop without a bound: 7 to 12 to 7"),
    }
    missing = [
        one for one in named if not any(line == one[0] and said.startswith(one[1]) for line, said in found)
    ]
    assert missing == []


def test_a_coin_until_heads() -> None:
    found = absorption({"toss": {"toss": 0.5, "heads": 0.5}}, "toss")
    assert found.ends == {"heads": 1.0}
    assert (found.steps, found.steps_sigma) == pytest.approx((2.0, np.sqrt(2.0)))


def test_a_chain_without_an_end_never_ends_however_it_is_rounded() -> None:
    rows = {"a": {"b": 1.0}, "b": {"a": 0.1, "b": 0.2, "c": 0.7}, "c": {"a": 1.0}}
    with pytest.raises(NeverEnds):
        absorption(rows, "a")
    with pytest.raises(NeverEnds):
        absorption({**rows, "start": {"a": 0.5, "end": 0.5}}, "start")


def test_a_loop_that_is_never_entered_has_no_part() -> None:
    found = absorption({"a": {"b": 0.0, "end": 1.0, "other": 0.0}, "b": {"b": 1.0}}, "a")
    assert found.ends == {"end": 1.0, "other": 0.0}
    assert found.steps == 1.0


def test_attempts_are_limited() -> None:
    found = forecast(network(("a", "z", 10.0, 3, None)), [Chance(0.9)])
    assert found.goal == pytest.approx(0.999)
    assert found.no_way == pytest.approx(0.001)
    assert found.cost_s == pytest.approx(10.0 * (1 + 0.1 + 0.01))


def test_giving_up_absorbs() -> None:
    found = forecast(network(("a", "z", 10.0, 3, None)), [Chance(0.8, 0.1)])
    assert found.give_up == pytest.approx(0.1 * (1 + 0.1 + 0.01))
    assert found.goal + found.give_up + found.no_way == pytest.approx(1.0)


def test_a_repeat_over_200_elements_is_exact_too() -> None:
    rows = []
    for i in range(200):
        rows += [
            (f"s{i:03}", f"s{i + 1:03}", 10.0, 2, f"b{i:03}"),
            (f"b{i:03}", f"s{i + 1:03}", 30.0, 1, None),
        ]
    found = forecast(network(*rows, start="s000", goal="s200"), [Chance(0.9)] * 400)
    # In b the first way is no longer there: it starts in s only.
    assert found.goal == pytest.approx((0.9 + 0.1 * 0.9) ** 200)


NETWORKS = st.lists(
    st.tuples(
        st.integers(0, 3), st.integers(0, 4), st.integers(1, 9), st.integers(1, 3), st.integers(-1, 3),
        st.sampled_from([0.3, 0.6, 0.9]), st.sampled_from([0.0, 0.1]),
    ),
    min_size=1,
    max_size=6,
)  # fmt: skip


def imagined(net: ActionNetwork, chances: Sequence[Chance], rng: random.Random) -> tuple[str, float, int]:
    """One run by the coordinator's own decisions: end, cost, actions."""
    route, cost, count = RunDecisions(net), 0.0, 0
    while not route.arrived:
        if not route.planned and isinstance(route.plan(), NoWay):
            return "no way", cost, count
        action = route.next
        chance, luck, count = chances[action.index], rng.random(), count + 1
        cost += action.cost_s
        if luck < chance.success:
            route.took(Success({}))
        elif luck < chance.success + chance.give_up:
            return "give up", cost, count
        else:
            route.failed("bad luck")
    return "goal", cost, count


@pytest.mark.slow
@given(NETWORKS)
@settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow], deadline=None)
def test_exact_figures_are_those_of_many_runs(
    rows: list[Any],
) -> None:
    """And every run ends within the bound that `check` states."""
    names = "abcdz"
    made = [
        (names[s], names[t], float(c), n, names[f] if f >= 0 and f != s else None)
        for s, t, c, n, f, _, _ in rows
    ]
    net = network(*made)
    chances = [Chance(p, min(g, 1.0 - p)) for *_, p, g in rows]
    exact, rng, count = forecast(net, chances), random.Random(0), 1500
    runs = [imagined(net, chances, rng) for _ in range(count)]
    assert max(actions for *_, actions in runs) <= net.bound()
    for name, p in (("goal", exact.goal), ("no way", exact.no_way), ("give up", exact.give_up)):
        share = sum(end == name for end, *_ in runs) / count
        assert share == pytest.approx(p, abs=5.0 * np.sqrt(p * (1.0 - p) / count) + 1e-9)
    costs = [cost for _, cost, _ in runs]
    assert np.mean(costs) == pytest.approx(exact.cost_s, abs=5.0 * exact.cost_sigma_s / np.sqrt(count) + 1e-9)
