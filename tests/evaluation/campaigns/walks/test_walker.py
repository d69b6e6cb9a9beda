"""Walks side by side, against the coordinator's own decisions and the exact figures."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from handcart.evaluation.campaigns.walks.odds import EndCode, context_of
from handcart.evaluation.campaigns.walks.walk_table import GOAL, NO_WAY, WalkTable
from handcart.evaluation.campaigns.walks.walker import GAVE_UP, NO_ACTION, Walked, Walker
from handcart.networks.analysis.forecast import forecast
from handcart.networks.chains.chance import Chance
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.graph.planner import NoWay
from handcart.networks.graph.route import RunDecisions
from handcart.primitives.driving.modify import Modify
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.numerics.arrays import FloatArray, Int8Array, Int32Array

BOUND = Binding.of(Modify(place="x"))
WALKS = 4000


class Even:
    """Ends with the same probabilities for all actions; each takes as long as its number says."""

    rest_s = 0.0

    def __init__(self, *limits: float) -> None:
        self.limits, self.contexts = np.array(limits), set[int]()

    def ends(self, action: Int32Array, context: Int32Array, drawn: FloatArray) -> Int8Array:
        self.contexts.update(context.tolist())
        return np.searchsorted(self.limits, drawn, side="right").astype(np.int8)

    def seconds(
        self, action: Int32Array, context: Int32Array, ends: Int8Array, drawn: FloatArray
    ) -> FloatArray:
        return np.asarray(action + 1.0, dtype=np.float64)


def some_network(seed: int) -> ActionNetwork:
    """With ways of the same weight, skips, and Fails that lead elsewhere."""
    rng = random.Random(seed)
    names = [f"s{i}" for i in range(7)]
    actions = []
    for source, target in (rng.sample(names, 2) for _ in range(18)):
        if rng.random() < 0.15:
            actions.append(Action(source, target, None, 1.0, 1))
            continue
        on_fail = rng.choice([None, None, *names])
        cost, attempts = float(rng.randint(1, 4)), rng.randint(1, 3)
        actions.append(Action(source, target, BOUND, cost, attempts, on_fail))
    return ActionNetwork.build(map(Situation, names), actions, "s0", "s6")


def again(network: ActionNetwork, walked: Walked, column: int) -> tuple[int, bool]:
    """Go through a walk as the coordinator plans: where it ends, whether something was left undone."""
    route, skipped = RunDecisions(network), False
    rows = zip(walked.action[:, column].tolist(), walked.ends[:, column].tolist(), strict=True)
    for index, code in rows:
        if route.arrived or (not route.planned and isinstance(route.plan(), NoWay)):
            assert index == NO_ACTION
            break
        if route.next.binding is None:
            assert index == NO_ACTION
            skipped = True
            route.took(Success())
            continue
        assert route.next.index == index
        if code == EndCode.SUCCESS:
            route.took(Success())
        elif code in (EndCode.FAIL, EndCode.FOR_GOOD):
            route.failed("", code == EndCode.FOR_GOOD)
        else:
            return GAVE_UP, skipped
    return GOAL if route.arrived else NO_WAY, skipped


@pytest.mark.parametrize("seed", range(25))
def test_it_does_what_the_coordinator_does(seed: int) -> None:
    network = some_network(seed)
    walked = Walker(WalkTable(network), Even(0.6, 0.85, 0.95, 0.98)).walk(np.random.default_rng(seed), 200)
    for column in range(200):
        assert again(network, walked, column) == (walked.last[column], walked.skipped[column])
    assert set(walked.last.tolist()) <= {GOAL, NO_WAY, GAVE_UP}


@pytest.mark.parametrize("seed", range(12))
def test_shares_are_the_exact_ones(seed: int) -> None:
    """Within four standard errors."""
    network = some_network(seed)
    chances = [None if action.binding is None else Chance(0.7, 0.03) for action in network.actions]
    exact = forecast(network, chances)
    walked = Walker(WalkTable(network), Even(0.7, 0.97, 0.97, 1.0)).walk(np.random.default_rng(seed), WALKS)
    for share, p in ((walked.success, exact.goal), (walked.last == GAVE_UP, exact.give_up)):
        assert abs(share.mean() - p) <= 4.0 * math.sqrt(p * (1.0 - p) / WALKS) + 1e-12


def test_times_add_up_and_nothing_follows_an_end() -> None:
    walked = Walker(WalkTable(some_network(3)), Even(0.5, 0.9, 0.9, 1.0)).walk(np.random.default_rng(1), 300)
    there = walked.action != NO_ACTION
    assert (walked.seconds == np.where(there, walked.action + 1.0, 0.0)).all()
    gave_up = (walked.ends == EndCode.GIVE_UP) & there
    assert gave_up.sum() == (walked.last == GAVE_UP).sum() > 0
    for step, column in np.argwhere(gave_up).tolist():
        assert not there[step + 1 :, column].any()


def test_a_fail_for_good_uses_up_all_attempts() -> None:
    names = map(Situation, ("a", "z"))
    network = ActionNetwork.build(names, [Action("a", "z", BOUND, 1.0, 3)], "a", "z")
    for limits, actions in (((0.0, 1.0, 1.0, 1.0), 3), ((0.0, 0.0, 1.0, 1.0), 1)):
        walked = Walker(WalkTable(network), Even(*limits)).walk(np.random.default_rng(0), 5)
        assert walked.action.shape == (actions, 5)
        assert (walked.last == NO_WAY).all()


def test_odds_are_told_what_came_before() -> None:
    names = map(Situation, ("a", "b", "z"))
    actions = [Action("a", "b", BOUND, 1.0, 4), Action("b", "z", BOUND, 1.0, 1)]
    odds = Even(0.5, 1.0, 1.0, 1.0)
    Walker(WalkTable(ActionNetwork.build(names, actions, "a", "z")), odds).walk(np.random.default_rng(0), 500)
    every = context_of(np.array([0, 1, 2, 3], dtype=np.int32), np.array([False, True, True, True]))
    assert odds.contexts == set(every.tolist())


def test_a_goal_that_is_the_start_takes_no_walk() -> None:
    network = ActionNetwork.build([Situation("a")], [], "a", "a")
    walked = Walker(WalkTable(network), Even(1.0)).walk(np.random.default_rng(0), 3)
    assert walked.success.all()
    assert walked.action.shape == (0, 3)
