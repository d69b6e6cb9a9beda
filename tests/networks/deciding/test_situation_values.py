"""Lower bounds of situations by their remaining attempts: many at once, and against an independent solver."""

from __future__ import annotations

import random
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.deciding.plain_solver import PlainNetwork, best_cost, plain_network
from benchmarks.deciding.random_networks import ANY_BINDING, NETWORK_FAMILIES, drawn
from handcart.networks.chains.chance import Chance
from handcart.networks.deciding.process import Process
from handcart.networks.deciding.situation_values import SituationValues
from handcart.networks.deciding.stay_values import MAX_SWAPPED_ACTIONS
from handcart.networks.graph.network import Action, ActionNetwork, Situation

PERSON_S = 600.0


def ring(count: int, choices: int) -> Process:
    """Return a ring of situations with several actions from each to the next, and a goal besides."""
    names = [f"s{number}" for number in range(count)]
    actions = [
        Action(name, names[(number + 1) % count], ANY_BINDING, 1.0 + choice)
        for number, name in enumerate(names)
        for choice in range(choices)
    ]
    actions.append(Action(names[-1], "z", ANY_BINDING, 3.0))
    network = ActionNetwork.build(map(Situation, [*names, "z"]), actions, names[0], "z")
    return Process(network, [Chance(0.5, 0.01)] * len(actions), PERSON_S)


@pytest.mark.parametrize(
    "process",
    [
        pytest.param(Process(*drawn("anywhere", 3), PERSON_S), id="few actions"),
        pytest.param(ring(24, MAX_SWAPPED_ACTIONS + 1), id="many actions"),
    ],
)
def test_many_bounds_at_once_equal_those_of_one_at_a_time(process: Process) -> None:
    part = max(range(len(process.parts)), key=lambda number: len(process.parts[number]))
    names = [name for name in process.parts[part] if name != process.network.goal]
    actions = [action for name in names for action in process.out[name]]
    draws = np.random.default_rng(0)
    attempts = draws.choice([0.0, 1.0, 2.0, np.inf], (20, len(actions)))
    places = np.tile(np.arange(len(names)), 20)[:20]
    together = SituationValues(process).with_attempts(part, attempts, places)
    for row, place, value in zip(attempts, places.tolist(), together.tolist(), strict=True):
        alone = SituationValues(process).with_attempts(part, row[None, :], np.array([place]))
        assert value == pytest.approx(alone[0], rel=1e-6)


@given(st.sampled_from(NETWORK_FAMILIES), st.integers(0, 10**6), st.integers(0, 10**6))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_bounds_by_attempts_never_exceed_the_least_cost(family: str, seed: int, used: int) -> None:
    """Some attempts are used up already, and the run is somewhere on its way."""
    task, draws = drawn(family, seed, 5), random.Random(used)
    network = task.network
    left = [draws.randint(0, action.attempts) for action in network.actions]
    start = draws.choice([name for name in network.situations if name != network.goal])
    edges = zip(plain_network(task).edges, left, strict=True)
    plain = PlainNetwork([edge._replace(attempts=count) for edge, count in edges], start, network.goal)
    process = Process(network, task.chances, PERSON_S)
    part = process.part[start]
    names = [name for name in process.parts[part] if name != network.goal]
    attempts = np.array([[float(left[item.index]) for name in names for item in process.out[name]]])
    values = SituationValues(process)
    bound = values.with_attempts(part, attempts, np.array([names.index(start)]))[0]
    assert bound <= best_cost(plain, PERSON_S, 1e-4, 2.0).high * (1.0 + 1e-9)
    assert bound >= values.value[start] * (1.0 - 1e-9)


@pytest.mark.parametrize("count", [2, MAX_SWAPPED_ACTIONS + 1])
def test_bound_of_actions_side_by_side_is_that_of_their_best_order(count: int) -> None:
    costs, chances = [10.0, 12.0, 3.0, 40.0, 7.0][:count], [0.4, 0.8, 0.1, 0.9, 0.3][:count]
    actions = [Action("a", "z", ANY_BINDING, cost, 1 + number % 2) for number, cost in enumerate(costs)]
    back = [Action("b", "a", ANY_BINDING, 1.0), Action("a", "b", ANY_BINDING, 590.0)]
    network = ActionNetwork.build(map(Situation, "abz"), [*actions, *back], "a", "z")

    def cost_of(order: tuple[int, ...]) -> float:
        left = PERSON_S
        for number in reversed(order):
            for _ in range(actions[number].attempts):
                left = costs[number] + (1.0 - chances[number]) * left
        return left

    expected = min(map(cost_of, permutations(range(count))))
    process = Process(network, [*map(Chance, chances), Chance(0.9), Chance(0.9)], PERSON_S)
    values, part = SituationValues(process), process.part["a"]
    assert values.value["a"] == pytest.approx(expected, rel=1e-12)
    names = process.parts[part]
    attempts = np.array([[float(item.attempts) for name in names for item in process.out[name]]])
    again = values.with_attempts(part, attempts, np.array([names.index("a")]))
    assert again[0] == pytest.approx(expected, rel=1e-12)
