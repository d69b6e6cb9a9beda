"""Figures of small networks against every run that there can be, and against runs of the coordinator."""

from __future__ import annotations

import math
import random
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from handcart.networks.analysis.forecast import Forecaster, forecast
from handcart.networks.analysis.worst_cases import worst_cases
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.policy import TooLarge, policy
from handcart.networks.chains.stage import Stage
from handcart.networks.chains.stages import stages
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.graph.planner import NoWay
from handcart.networks.graph.route import RunDecisions
from handcart.primitives.driving.modify import Modify
from handcart.primitives.outcomes.outcome import Success
from tests.networks.conftest import Stand

BOUND = Binding.of(Modify(place="x"))


Row = tuple[str, str, float | None, int, str | None]


def network(*rows: Row, start: str = "a", goal: str = "z") -> ActionNetwork:
    """Rows of source, target, cost (None: a skip), attempts, on_fail."""
    names = sorted({name for s, t, _, _, f in rows for name in (s, t, f) if name} | {start, goal})
    actions = [
        Action(s, t, None, 1.0, 1) if cost is None else Action(s, t, BOUND, cost, attempts, on_fail)
        for s, t, cost, attempts, on_fail in rows
    ]
    return ActionNetwork.build(map(Situation, names), actions, start, goal)


@dataclass
class Every:
    """Totals over all runs of a network."""

    ends: Any = field(default_factory=Counter)
    cost: float = 0.0
    square: float = 0.0
    longest: int = 0
    used: set[int] = field(default_factory=set)
    no_way_in: set[str] = field(default_factory=set)

    @property
    def sigma(self) -> float:
        return math.sqrt(max(0.0, self.square - self.cost**2))


def follow(net: ActionNetwork, words: Iterable[str]) -> tuple[list[tuple[Action, str]], str, RunDecisions]:
    """Follow the coordinator if its actions end with these outcomes, then all in Success.

    Returns:
        The actions with their outcomes, the end in words, and the route.
    """
    did: list[tuple[Action, str]] = []
    route, skipped, words = RunDecisions(net), False, iter(words)
    while not route.arrived:
        if not route.planned and isinstance(route.plan(), NoWay):
            return did, "no way", route
        action = route.next
        if action.binding is None:
            route.took(Success({}))
            skipped = True
            continue
        word = next(words, "S")
        did.append((action, word))
        if word == "S":
            route.took(Success({}))
        elif word == "G":
            return did, "give up", route
        else:
            route.failed("bad luck", word == "P")
    return did, "skipped" if skipped else "goal", route


def every(net: ActionNetwork, chances: Sequence[Any] | None = None, most: int = 4000) -> Every | None:
    """Enumerate all runs of a network one by one; without chances also those with Fails for good."""
    found = Every()
    ahead: list[tuple[str, ...]] = [()]
    for _ in range(most):
        if not ahead:
            return found
        known = ahead.pop()
        did, end, route = follow(net, known)
        fails = "FG" if chances else "FPG"
        for number in range(len(known), len(did)):
            before = (*known, *("S" for _ in range(number - len(known))))
            ahead += [(*before, word) for word in fails]
        p, cost = 1.0, sum(action.cost_s for action, _ in did)
        for action, word in did:
            found.used.add(action.index)
            chance = chances[action.index] if chances else Chance(0.5)
            p *= {"S": chance.success, "G": chance.give_up}.get(word, chance.fail)
        found.ends[end] += p
        found.cost += p * cost
        found.square += p * cost * cost
        found.longest = max(found.longest, len(did))
        found.no_way_in |= {route.situation} if end == "no way" else set()
    return None


ROWS = st.tuples(
    st.sampled_from("abcd"),
    st.sampled_from("abcdz"),
    st.sampled_from([1.0, 2.0, 3.0, 5.0, 7.0, None]),
    st.integers(1, 3),
    st.sampled_from(["a", "b", "c", "d", "z", None, None, None]),
)
SPINE = st.tuples(
    *(
        st.tuples(st.just(a), st.just(b), st.sampled_from([1.0, 4.0]), st.integers(1, 2), st.none())
        for a, b in ("ab", "bc", "cz")
    )
)
# Most random rows lead nowhere: one half of the networks has a way to the goal for sure.
NETWORKS = st.lists(ROWS, min_size=2, max_size=6) | st.tuples(SPINE, st.lists(ROWS, max_size=3)).map(
    lambda both: [*both[0], *both[1]]
)
CHANCES = st.lists(
    st.builds(Chance, st.sampled_from([0.3, 0.6, 0.9]), st.sampled_from([0.0, 0.1])), min_size=6, max_size=6
)
LOOSE = settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))


def chances_of(net: ActionNetwork, chances: Sequence[Chance]) -> list[Chance | None]:
    return [None if a.binding is None else c for a, c in zip(net.actions, chances, strict=False)]


@pytest.mark.slow
@given(NETWORKS, CHANCES)
@LOOSE
def test_figures_are_those_of_every_run_that_there_can_be(rows: list[Row], chances: list[Chance]) -> None:
    net = network(*rows)
    known = chances_of(net, chances)
    true = every(net, known)
    assume(true is not None)
    assert true is not None
    found = forecast(net, known)
    ends = [true.ends[name] for name in ("goal", "skipped", "no way", "give up")]
    assert [found.goal, found.left_undone, found.no_way, found.give_up] == pytest.approx(ends, abs=1e-9)
    assert found.cost_s == pytest.approx(true.cost)
    assert found.cost_sigma_s == pytest.approx(true.sigma, abs=1e-5)


@pytest.mark.slow
@given(NETWORKS)
@LOOSE
def test_worst_cases_are_those_of_every_run_that_there_can_be(rows: list[Row]) -> None:
    net = network(*rows)
    true = every(net)
    assume(true is not None)
    assert true is not None
    found = worst_cases(net)
    assert found.longest == true.longest <= net.bound()
    bound = {action.index for action in net.actions if action.binding is not None}
    assert {action.index for action in found.unused} == bound - true.used
    assert {item.situation for item in found.short} == true.no_way_in


@pytest.mark.slow
@given(NETWORKS, CHANCES)
@LOOSE
def test_slopes_are_derivatives(rows: list[Row], chances: list[Chance]) -> None:
    net = network(*rows)
    known = chances_of(net, chances)
    slopes = Forecaster(net, known).slopes()
    for number, chance in enumerate(known):
        if chance is not None:
            around = [
                forecast(
                    net,
                    [*known[:number], Chance(chance.success + step, chance.give_up), *known[number + 1 :]],
                )
                for step in (1e-5, -1e-5)
            ]
            assert slopes[number] == pytest.approx((around[0].goal - around[1].goal) / 2e-5, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_figures_are_those_of_the_coordinators_runs(new_stand: Callable[[], Stand], seed: int) -> None:
    """Whole runs, robot and all: a detour, an alternative, a loop."""
    stand, rng, count = new_stand(), random.Random(seed), 400
    names = ["drive", "modify", "around", "pick", "other", "place"]
    net = stand.network(
        "a b drive 30 3 blocked", "blocked known modify 1", "known b around 40 2 blocked",
        "b c pick 15 2", "b c other 25 2", "c z place 10",
    )  # fmt: skip
    chances = [Chance(0.6, 0.02), Chance(0.9), Chance(0.7), Chance(0.5), Chance(0.6, 0.05), Chance(0.8)]
    exact = forecast(net, chances)
    ends: Counter[str] = Counter()
    costs = []
    for _ in range(count):
        stand = new_stand()
        for name, chance in zip(names, chances, strict=True):
            weights = [chance.success, chance.fail, chance.give_up]
            stand.script[name] = deque(rng.choices("SFG", weights, k=30))
        events: list[Any] = []
        end = stand.finish(Coordinator(net, stand.robot, stand.model, observers=[events.append]))
        assert end.actions <= worst_cases(net).longest
        ends[end.outcome] += 1
        started = Counter(event.primitive.name for event in events if type(event).__name__ == "Started")
        costs.append(sum(started[n] * a.cost_s for n, a in zip(names, net.actions, strict=True)))
    for outcome, p in (("Success", exact.goal), ("Fail", exact.no_way), ("GiveUp", exact.give_up)):
        assert ends[outcome] / count == pytest.approx(p, abs=4.0 * math.sqrt(p * (1.0 - p) / count))
    assert np.mean(costs) == pytest.approx(exact.cost_s, abs=4.0 * exact.cost_sigma_s / math.sqrt(count))


def test_a_certain_action_has_no_slope_where_attempts_remain() -> None:
    net = network(("a", "z", 10.0, 3, None))
    assert Forecaster(net, [Chance(1.0)]).slopes() == [0.0]
    assert Forecaster(net, [Chance(0.9)]).slopes() == [pytest.approx(3 * 0.1**2)]


def test_one_more_attempt_and_an_alternative() -> None:
    forecaster = Forecaster(network(("a", "z", 10.0, 2, None)), [Chance(0.9)])
    assert forecaster.forecast(Stage.with_one_more, {0}).goal == pytest.approx(1 - 0.1**3)
    assert forecaster.forecast(Stage.with_alternatives, {0}).goal == pytest.approx(1 - 0.1**4)
    # An action with the maximum number of attempts stays as it is.
    forecaster = Forecaster(network(("a", "z", 10.0, 20, None)), [Chance(0.1)])
    assert forecaster.forecast(Stage.with_one_more, {0}) == forecaster.forecast()


def repeated(elements: int) -> ActionNetwork:
    rows: list[Row] = []
    for i in range(elements):
        rows += [
            (f"s{i:03}", f"s{i + 1:03}", 30.0, 3, f"b{i:03}"),
            (f"b{i:03}", f"d{i:03}", 1.0, 3, None),
            (f"d{i:03}", f"s{i + 1:03}", 40.0, 3, f"b{i:03}"),
            (f"s{i:03}", f"s{i + 1:03}", None, 1, None),
            (f"b{i:03}", f"s{i + 1:03}", None, 1, None),
        ]
    return network(*rows, start="s000", goal=f"s{elements:03}")


def test_two_hundred_elements_are_as_many_times_one() -> None:
    chances = [Chance(0.9), Chance(0.95), Chance(0.8), None, None]
    one = Forecaster(repeated(1), chances)
    net = repeated(200)
    many = Forecaster(net, chances * 200)
    found = many.forecast()
    assert len(stages(net)) == 200
    assert found.goal == pytest.approx(one.forecast().goal ** 200)
    assert found.goal + found.left_undone == pytest.approx(1.0)
    assert found.cost_s == pytest.approx(200 * one.forecast().cost_s)
    assert found.cost_sigma_s == pytest.approx(math.sqrt(200) * one.forecast().cost_sigma_s)
    assert many.starts() == pytest.approx(one.starts() * 200)
    assert worst_cases(net).longest == 200 * worst_cases(repeated(1)).longest


@pytest.mark.slow
def test_too_many_states_give_an_interval_around_the_value() -> None:
    rows = [(f"s{i:02}", f"s{i + 1:02}", 1.0, 3, None) for i in range(20)]
    net = network(*rows, ("s19", "s00", 1.0, 3, None), start="s00", goal="s20")
    with pytest.raises(TooLarge, match=r"between s00 and s20 has more than \d+ states"):
        policy(net)
    found = forecast(net, [Chance(0.9)] * 21)
    assert found.unknown > 0.0
    assert found.goal <= (1.0 - 0.1**3) ** 20 <= found.goal_high < 1.0
    assert found.goal_high - found.goal == pytest.approx(found.unknown)
    assert found.cost_s < found.cost_high_s


def test_the_path_to_where_nothing_is_left() -> None:
    net = network(("a", "b", 5.0, 2, None), ("b", "z", 5.0, 1, "c"), ("c", "z", 9.0, 2, None))
    assert [(item.situation, item.words()) for item in worst_cases(net).short] == [
        ("a", "MODIFY from a fails 2 times"),
        ("c", "MODIFY from b fails, MODIFY from c fails 2 times"),
    ]


def test_what_follows_a_skip_does_not_help_to_the_goal() -> None:
    net = network(("a", "b", 5.0, 1, None), ("a", "b", None, 1, None), ("b", "z", 5.0, 2, "a"))
    chances = [Chance(0.5), None, Chance(0.8)]
    forecaster = Forecaster(net, chances)
    found = forecaster.forecast()
    # After a Fail in b it comes back to a, from where a second try goes through the first way again.
    assert found.goal == pytest.approx(0.5 * (0.8 + 0.2 * 0.5 * 0.8))
    assert found.left_undone == pytest.approx(0.96 - found.goal)
    assert forecaster.slopes()[2] == pytest.approx(0.5 * (1 + 0.5 * (0.2 - 0.8)))


def test_what_cannot_come_up_again_is_forgotten() -> None:
    """One detour and nine actions in a row, as in the paper's task: not 3 states for each, multiplied."""
    names = "abcdefghi"
    rows = [(s, t, 5.0, 3, None) for s, t in pairwise(names)]
    net = network(*rows, ("i", "z", 5.0, 3, None))
    assert len(policy(net).steps) == 9 * 4
