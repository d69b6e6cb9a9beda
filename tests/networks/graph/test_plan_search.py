"""Plans for many states, and how much is searched for them."""

from __future__ import annotations

import itertools
import random

import networkx as nx
import pytest

from benchmarks.analysis import network
from handcart.networks.analysis.forecast import forecast
from handcart.networks.analysis.worst_cases import worst_cases
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import TooLarge, policy
from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.graph.plan_search import PlanSearch
from handcart.networks.graph.planner import Plan, Planner


@pytest.mark.parametrize("seed", range(40))
def test_it_plans_what_the_planner_plans(seed: int) -> None:
    """Ways of the same weight and skips included."""
    rng = random.Random(seed)
    names = [f"s{i}" for i in range(8)]
    bound = network("chain", 3).actions[0].binding
    actions = [
        Action(a, b, rng.choice([bound, bound, None]), float(rng.randint(1, 4)), 2)
        for a, b in (rng.sample(names, 2) for _ in range(24))
    ]
    net = ActionNetwork.build(map(Situation, names), actions, "s0", "s7")
    search = PlanSearch(net)
    for _ in range(20):
        fails = {n: rng.randint(1, 2) for n in rng.sample(range(24), 6) if net.actions[n].binding}
        planner = Planner(net)
        for number, count in fails.items():
            for _ in range(count):
                planner.failed(net.actions[number], "")
        for name in names:
            plan = planner.plan(name)
            assert search.plan(name, fails) == (plan.actions if isinstance(plan, Plan) else None)


@pytest.mark.parametrize("seed", range(30))
def test_routes_are_those_of_networkx(seed: int) -> None:
    """Of equally cheap routes it is the same one; several actions lead from one situation to another."""
    rng = random.Random(seed)
    names = [f"s{i}" for i in range(8)]
    bound = network("chain", 3).actions[0].binding
    pairs = [tuple(rng.sample(names, 2)) for _ in range(26)]
    actions = [Action(a, b, bound, float(rng.randint(1, 1 + seed % 9)), 2) for a, b in pairs]
    net = ActionNetwork.build(map(Situation, names), actions, "s0", "s7")
    for fails in ({}, {rng.randrange(26): 1 for _ in range(6)}):
        cost = {a.index: a.cost_s * 2 ** fails.get(a.index, 0) for a in net.actions}
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(names)
        for action in net.actions:
            known = graph.get_edge_data(action.source, action.target, {"action": action.index})["action"]
            best = min(known, action.index, key=lambda index: (cost[index], index))
            graph.add_edge(action.source, action.target, action=best, weight=cost[best])
        search = PlanSearch(net)
        for name in names:
            try:
                route = nx.dijkstra_path(graph, name, "s7")
            except nx.NetworkXNoPath:
                assert search.plan(name, fails) is None
                continue
            edges = [graph[a][b]["action"] for a, b in itertools.pairwise(route)]
            assert [action.index for action in search.plan(name, fails) or ()] == edges


def test_what_is_too_much_is_told_and_is_the_same_each_time() -> None:
    """The limit counts steps, and does not depend on a clock."""
    net, messages = network("grid", 100), set()
    for _ in range(2):
        with pytest.raises(TooLarge) as large:
            policy(net, effort=Effort(20_000))
        messages.add(str(large.value))
    assert len(messages) == 1
    assert "the part between g0,0 and g9,9 has more than" in messages.pop()


def test_who_watches_hears_how_much_is_spent() -> None:
    shares: list[float] = []
    with pytest.raises(TooLarge):
        policy(network("grid", 100), effort=Effort(20_000, shares.append))
    assert shares == sorted(shares)
    assert len(shares) > 3
    assert shares[-1] <= 1.0


def test_a_part_that_is_too_large_leaves_the_rest_known() -> None:
    easy, hard = network("chain", 20), network("grid", 49)
    joined = [*easy.situations.values(), *hard.situations.values()]
    bridge = Action(easy.goal, hard.start, easy.actions[0].binding, 1.0, 1)
    net = ActionNetwork.build(joined, [*easy.actions, bridge, *hard.actions], easy.start, hard.goal)
    cases = worst_cases(net, Effort(20_000))
    assert [str(item).partition(" has")[0] for item in cases.too_large] == ["the part between g0,0 and g6,6"]
    assert {item.situation for item in cases.short} >= {action.source for action in (*easy.actions, bridge)}
    assert 3 * len(easy.actions) + 1 < cases.longest_low < cases.longest <= net.bound()


@pytest.mark.slow
def test_a_thousand_situations_in_a_row() -> None:
    net = network("chain", 1000)
    found = forecast(net, [Chance(0.99)] * len(net.actions))
    assert found.goal == pytest.approx((1.0 - 0.01**3) ** len(net.actions))
    assert worst_cases(net).longest == 3 * len(net.actions)
