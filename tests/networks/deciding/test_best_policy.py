"""The best policy against an independent solver, and what its figures promise."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.deciding.plain_solver import PlainNetwork, best_cost, plain_network, rule_ends
from benchmarks.deciding.random_networks import ANY_BINDING, NETWORK_FAMILIES, Drawn, drawn
from handcart.networks.analysis.forecast import Forecaster
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.step_maker import State
from handcart.networks.deciding.best_planner import BestPlanner
from handcart.networks.deciding.best_policy import BestPolicy
from handcart.networks.deciding.comparison import comparison
from handcart.networks.deciding.process import Process
from handcart.networks.deciding.run_figures import best_figures, rule_figures
from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.graph.planner import Plan

START = State("s0", ())
Row = tuple[str, str, float, int, float, float, str | None]


def built(*rows: Row, goal: str = "z") -> Drawn:
    """Rows of source, target, cost, attempts, p, p_give_up, on_fail; a p of 0 with attempts 0 is a skip."""
    names = dict.fromkeys(name for s, t, *_, f in rows for name in (s, t, f) if name)
    actions = [
        Action(s, t, ANY_BINDING, cost, attempts, f) if attempts else Action(s, t, None, 1.0, 1)
        for s, t, cost, attempts, _, _, f in rows
    ]
    chances = [Chance(p, give_up) if attempts else None for _, _, _, attempts, p, give_up, _ in rows]
    return Drawn(ActionNetwork.build(map(Situation, names), actions, rows[0][0], goal), chances)


def best_of(task: Drawn, person_s: float = 600.0, steps: float | None = None) -> BestPolicy:
    effort = None if steps is None else Effort(steps)
    return BestPolicy(task.network, task.chances, "expected_cost", person_s, effort)


networks = st.builds(drawn, st.sampled_from(NETWORK_FAMILIES), st.integers(0, 10**6), st.just(5))


def test_actions_out_of_the_goal_leave_a_price_for_each_end() -> None:
    """No run does them, and what follows them is not on the way to the goal."""
    network = built(("a", "z", 1, 1, 0.5, 0.0, None), ("z", "b", 1, 1, 1.0, 0.0, None)).network
    process = Process(network, [Chance(0.5), Chance(1.0)], 600.0)
    assert {name: process.stop_price(name) for name in network.situations} == dict.fromkeys("azb", 600.0)


@given(task=networks)
@settings(max_examples=10, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_least_cost_equals_that_of_an_independent_solver(task: Drawn) -> None:
    plain = plain_network(task)
    expected = best_cost(plain, 600.0, 1e-4, 3.0)
    found = best_of(task).decision(START)
    assert found.low <= expected.high * (1.0 + 1e-9)
    assert found.cost >= expected.low * (1.0 - 1e-9)
    assert found.cost - found.low <= 1e-3 * found.cost


@pytest.mark.slow
@pytest.mark.parametrize(("family", "seed"), [("back", 31), ("back", 36), ("back", 48), ("anywhere", 1)])
def test_least_cost_is_found_where_many_fails_count(family: str, seed: int) -> None:
    """Networks that a search one state at a time left with a gap of up to 5e-3."""
    best = best_of(drawn(family, seed), steps=300_000.0)
    found = best.decision(START)
    assert found.cost - found.low <= 1e-3 * found.cost
    price = best_figures(best.process, best.policy(), "best").price_s[0]
    assert found.low * (1.0 - 1e-9) <= price <= found.cost * (1.0 + 1e-4)


@pytest.mark.parametrize(
    ("rows", "person_s", "cost"),
    [
        pytest.param(
            [("a", "b", 10, 20, 0.9, 0.0, "z"), ("b", "a", 10, 20, 0.9, 0.0, "z")],
            600.0,
            100.0,
            id="a circle that one step in ten leaves (storm 1061)",
        ),
        pytest.param(
            [
                ("a", "trap", 1, 1, 0.99, 0.0, None),
                ("a", "b", 5, 3, 1.0, 0.0, None),
                ("trap", "other", 1, 1, 1.0, 0.0, None),
                ("other", "trap", 1, 1, 1.0, 0.0, None),
                ("b", "z", 5, 3, 1.0, 0.0, "a"),
            ],
            600.0,
            10.0,
            id="a trap that circles for ever (storm 555)",
        ),
        pytest.param(
            [
                ("a", "b", 1, 1, 1.0, 0.0, None),
                ("b", "a", 1, 1, 1.0, 0.0, None),
                ("b", "z", 500, 1, 0.5, 0.0, None),
            ],
            1000.0,
            1000.0,
            id="certain steps in a circle cost more than a person",
        ),
    ],
)
def test_least_cost_in_circles_is_exact(rows: list[Row], person_s: float, cost: float) -> None:
    """The circles of reports to other solvers, whose iterations ended early or never."""
    decision = best_of(built(*rows), person_s).decision(State("a", ()))
    assert decision.low == pytest.approx(decision.cost, rel=1e-8)
    assert decision.cost == pytest.approx(cost, rel=1e-8)


@given(task=networks)
@settings(max_examples=10, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_rule_figures_equal_those_of_an_independent_solver(task: Drawn) -> None:
    expected = rule_ends(plain_network(task), 1e-6, 3.0)
    process = Process(task.network, task.chances, 600.0)
    found = rule_figures(process, Forecaster(task.network, task.chances))
    assert found.goal[0] <= expected.goal.high + 1e-9
    assert found.goal[1] >= expected.goal.low - 1e-9
    if found.goal[0] == found.goal[1]:
        price = expected.time + 600.0 * (1.0 - expected.goal.low)
        assert found.price_s[0] == pytest.approx(price, rel=1e-3)


@given(task=networks, steps=st.sampled_from([300.0, 3000.0, 30000.0]))
@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_a_policy_costs_no_more_than_its_bound(task: Drawn, steps: float) -> None:
    """Also where the budget ends the search early."""
    best = best_of(task, steps=steps)
    promised = best.decision(START)
    found = best_figures(best.process, best.policy(), "best")
    assert found.price_s[1] <= promised.cost * (1.0 + 1e-9)
    assert found.price_s[1] >= promised.low * (1.0 - 1e-9)


@pytest.mark.slow
@given(task=networks)
@settings(max_examples=10, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_the_followed_policy_never_costs_more_than_the_rule(task: Drawn) -> None:
    found = comparison(task.network, task.chances)
    assert found.best.price_s[0] <= found.rule.price_s[1] * (1.0 + 1e-9)
    largest = comparison(task.network, task.chances, "goal_probability")
    assert largest.best.goal[0] >= found.rule.goal[0] - 1e-7


@pytest.mark.parametrize(
    ("rows", "rule", "best"),
    [
        pytest.param(
            [("a", "z", 10, 3, 0.6, 0.3, None), ("a", "z", 12, 3, 0.99, 0.0, None)],
            0.7,
            0.9999,
            id="a GiveUp that costs do not show",
        ),
        pytest.param(
            [
                ("a", "z", 10, 3, 0.5, 0.0, "stuck"),
                ("a", "b", 10, 3, 0.99, 0.0, None),
                ("b", "z", 10, 3, 0.99, 0.0, None),
            ],
            0.5,
            0.9999,
            id="a trap behind a Fail",
        ),
        pytest.param(
            [
                ("a", "b", 5, 1, 0.7, 0.0, None),
                ("b", "z", 5, 1, 0.4, 0.0, None),
                ("a", "z", 20, 3, 0.95, 0.0, None),
            ],
            0.58,
            0.9999,
            id="cheap steps without a way back",
        ),
    ],
)
def test_traps_that_the_rule_walks_into_are_avoided(rows: list[Row], rule: float, best: float) -> None:
    task = built(*rows)
    found = comparison(task.network, task.chances)
    assert found.rule.goal[0] == pytest.approx(rule, abs=0.02)
    assert found.best.goal[0] == pytest.approx(best, abs=2e-4)
    assert found.differences[0].situation == "a"


def test_a_fail_that_leads_on_is_used() -> None:
    rows: list[Row] = [
        ("a", "z", 90, 1, 0.5, 0.0, None),
        ("a", "dead", 5, 1, 0.1, 0.0, "b"),
        ("b", "z", 5, 3, 0.99, 0.0, None),
    ]
    task = built(*rows)
    found = comparison(task.network, task.chances)
    # Try the Fail's way first or last: P is .95 after the first line, .9 before it alone.
    assert found.best.price_s[0] == pytest.approx(best_cost(plain_network(task), 600.0).high, rel=1e-4)


def test_a_person_is_called_where_the_task_costs_more() -> None:
    task = built(("a", "b", 500, 1, 0.9, 0.0, None), ("b", "z", 500, 1, 0.9, 0.0, None))
    found = comparison(task.network, task.chances)
    assert found.best.price_s == (600.0, 600.0)
    assert found.call_limit_s == pytest.approx((500 + 0.9 * 500) / 0.81)
    planner = BestPlanner(best_of(task))
    assert getattr(planner.plan("a"), "calls_person", False)
    just_above = best_of(task, 1174.0)
    assert just_above.decision(State("a", ())).action is not None


@pytest.mark.parametrize(("second_s", "cost"), [(10, 65.0), (60, 100.0)])
def test_an_element_is_skipped_where_others_can_still_be_done(second_s: float, cost: float) -> None:
    """To call a person leaves all that follow undone as well."""
    rows: list[Row] = [("a", "b", 10, 1, 0.5, 0.0, None), ("a", "b", 1, 0, 0.0, 0.0, None)]
    rows += [("b", "z", second_s, 1, 0.9, 0.0, None), ("b", "z", 1, 0, 0.0, 0.0, None)]
    best, failed = best_of(built(*rows), 50.0), State("a", ((0, 1),))
    # 50 for the first element, then 10 + 0.1 * 50 for the second, or 50 for it too
    assert best.decision(failed).cost == pytest.approx(cost)
    action = best.step(failed).action
    assert (action is not None and action.binding is None) == (second_s == 10)


def test_the_rule_is_followed_where_the_search_finds_less() -> None:
    task = built(("a", "z", 10, 3, 0.99, 0.0, None), ("a", "z", 11, 3, 0.99, 0.0, None))
    best = best_of(task, steps=1.0)
    assert best.is_rule_better()
    plan = BestPlanner(best).plan("a")
    assert isinstance(plan, Plan)
    assert plan.actions == task.network.actions[:1]
    assert not best_of(task).is_rule_better()


def test_plain_solver_knows_a_network_by_hand() -> None:
    task = built(("a", "z", 10, 2, 0.5, 0.0, None))
    plain: PlainNetwork = plain_network(task)
    # 10 + half of (10 + half of 100), against 100 at once
    assert best_cost(plain, 100.0).high == pytest.approx(40.0)
    assert rule_ends(plain).goal.low == pytest.approx(0.75)
