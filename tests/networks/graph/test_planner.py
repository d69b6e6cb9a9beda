"""Planning: weights, ties, and what blocks (rows N11, N14)."""

import os
import subprocess
import sys

import pytest

from handcart.networks.graph.network import Action, ActionNetwork, Binding, NetworkError, Situation
from handcart.networks.graph.planner import NoWay, Plan, Planner
from tests.networks.conftest import Stand

SCRIPT = """
from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.graph.planner import Planner
names = [f"situation {n}" for n in range(30)]
actions = [Action(a, b, None) for a in names for b in names[::3] if a != b]
planner = Planner(ActionNetwork.build(map(Situation, names), actions, names[1], names[27]))
for _ in range(12):
    plan = planner.plan(names[1])
    print([action.index for action in plan.actions])
    planner.failed(plan.actions[0], "x")
"""


def plan_of(planner: Planner) -> Plan:
    plan = planner.plan("a")
    assert isinstance(plan, Plan)
    return plan


def test_each_fail_doubles_the_weight(stand: Stand) -> None:
    network = stand.network("a z one 3", "a z two 10")
    planner = Planner(network)
    costs = []
    for _ in range(3):
        costs.append(plan_of(planner).cost)
        planner.failed(plan_of(planner).actions[0], "x")
    assert costs == [3.0, 6.0, 10.0]
    assert planner.fails(network.actions[0]) == 2
    assert network.actions[0].cost_s == 3.0


def test_ties_go_to_the_first_in_the_network(stand: Stand) -> None:
    network = stand.network("a z one 3", "a z two 3")
    assert plan_of(Planner(network)).actions[0].index == 0


def test_a_permanent_fail_is_out_at_once(stand: Stand) -> None:
    network = stand.network("a z one 3")
    planner = Planner(network)
    planner.failed(network.actions[0], "no such thing", permanent=True)
    found = planner.plan("a")
    assert isinstance(found, NoWay)
    assert found.blocking == network.actions
    assert found.explanation == ("no way left from a to z: THINK (a to z) failed 1 time, last: no such thing")


def test_only_what_would_lead_on_blocks(stand: Stand) -> None:
    network = stand.network("a b dead_end 1", "a z way 2", "b c further 1")
    planner = Planner(network)
    for action in network.actions[:2]:
        planner.failed(action, "x", permanent=True)
    found = planner.plan("a")
    assert isinstance(found, NoWay)
    assert [action.index for action in found.blocking] == [1]


def test_the_network_never_changes(stand: Stand) -> None:
    network = stand.network("a z one 3")
    with pytest.raises(Exception, match=r"[Ff]rozen"):
        network.graph.add_edge("a", "z")


@pytest.mark.slow
def test_same_plans_whatever_the_hash_seed() -> None:
    """N11."""
    said = {
        subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, "PYTHONHASHSEED": seed},
            check=True,
            capture_output=True,
        ).stdout
        for seed in ("0", "1", "4711")
    }
    assert len(said) == 1


@pytest.mark.slow
def test_a_hundred_thousand_actions(stand: Stand) -> None:
    """N14; benchmarks/coordinator.py measures its duration."""
    names = [f"s{n}" for n in range(30_000)]
    bound = Binding.of(stand.Think(name="x"))
    actions = [
        Action(name, names[(number + step) % len(names)], bound)
        for number, name in enumerate(names)
        for step in (1, 7, 113)
    ]
    planner = Planner(ActionNetwork.build(map(Situation, names), actions, names[0], names[-1]))
    plan = planner.plan(names[0])
    assert isinstance(plan, Plan)
    assert plan.cost == len(plan.actions) == 30_000 // 113 + 54 // 7 + 54 % 7


def test_more_actions_than_can_be_planned_over_are_refused(
    stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    """N14, N10: so that no plan takes longer than the robot may be left without one."""
    monkeypatch.setattr("handcart.networks.graph.network.MAX_ACTIONS", 2)
    stand.network("a b one 1", "b z two 1")
    with pytest.raises(NetworkError, match="the network has 3 actions; allowed: at most 2"):
        stand.network("a b one 1", "b z two 1", "a z three 1")


def test_leaving_undone_is_dearer_than_whatever_can_be_tried(stand: Stand) -> None:
    bound = Binding.of(stand.Think(name="x"))
    ways = [Action("a", "z", None, 1.0), Action("a", "z", bound, 86_400.0, attempts=12)]
    planner = Planner(ActionNetwork.build(map(Situation, "az"), ways, "a", "z"))
    for _ in range(11):
        assert plan_of(planner).actions[0].index == 1
        planner.failed(plan_of(planner).actions[0], "x")
    planner.failed(planner.network.actions[1], "x")
    assert plan_of(planner).actions[0].index == 0


def test_a_plan_tells_what_is_out(stand: Stand) -> None:
    network = stand.network("a z one 3 1", "a z two 10")
    planner = Planner(network)
    assert plan_of(planner).excluded == ()
    planner.failed(network.actions[0], "x")
    assert plan_of(planner).excluded == (network.actions[0],)
