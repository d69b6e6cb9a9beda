"""Values of each alternative in `explain`: P(goal), time, and the change that would alter the choice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from handcart.evaluation.viewing.explanation.explanation_words import choice_words
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.planner import Plan, Planner
from handcart.networks.past_runs.hindsight import Choice, choice_of
from handcart.networks.past_runs.past_run import read_run

TASK = """\
format: handcart-task/1
title: Two ways
robot: librarian
start: a
goal: z
situations: {a: {}, b: {}, c: {}, z: {}}
actions:
  - {do: THINK, from: a, to: b, cost_s: 2, attempts: 2, p: 0.5, on_fail: c, with: {name: near}}
  - {do: THINK, from: b, to: z, cost_s: 1, p: 0.9, attempts: 1, with: {name: ahead}}
  - {do: THINK, from: a, to: z, cost_s: 6, p: 0.8, attempts: 1, with: {name: far}}
  - {do: THINK, from: c, to: a, cost_s: 1, p: 1.0, with: {name: back}}
"""
Make = Callable[..., Path]


def choice(folder: Path, number: int = 1) -> Choice:
    run = read_run(folder)
    found = choice_of(run, run.actions[number - 1])
    assert found is not None
    return found


def test_each_alternative_has_its_figures(scripted_run: Make) -> None:
    near, far = choice(scripted_run(TASK, "run")).options
    assert near.value is not None
    assert far.value is not None
    # far now: 0.8; after its Fail near, then near again at twice the weight, each with ahead behind it
    again = 0.5 * 0.9 + 0.5 * (0.5 * 0.9)
    assert far.value.goal == pytest.approx(0.8 + 0.2 * again, abs=1e-12)
    # near now: ahead after its Success; after its Fail it weighs 4 + 1 s, which is less than 6 s
    second = 0.5 * 0.9 + 0.5 * 0.8
    assert near.value.goal == pytest.approx(0.5 * 0.9 + 0.5 * second, abs=1e-12)
    once = 2.0 + 0.5 * 1.0
    assert near.value.mean_s == pytest.approx(once + 0.5 * (1.0 + once + 0.5 * (1.0 + 6.0)), abs=1e-12)


def test_without_probabilities_there_are_no_figures(scripted_run: Make) -> None:
    found = choice(scripted_run(TASK.replace("p: 0.8, ", ""), "run"))
    assert [option.value for option in found.options] == [None, None]
    assert not any("P(goal)" in line for line in choice_words(found))


def test_the_words_name_figures_and_what_would_change_it(scripted_run: Make) -> None:
    lines = list(choice_words(choice(scripted_run(TASK, "run"))))
    assert lines[0] == "cheapest way to the goal, 3 s: THINK, THINK; P(goal) 0.8750, 6.0 s in the mean"
    assert any("instead THINK (a to z): 6 s: THINK; P(goal) 0.9350" in line for line in lines)
    assert any("; chosen below 3 s instead of 6 s" in line for line in lines)


def cheaper(network: ActionNetwork, index: int, cost_s: float) -> ActionNetwork:
    actions = [replace(a, cost_s=cost_s) if a.index == index else a for a in network.actions]
    return ActionNetwork.build(network.situations.values(), actions, network.start, network.goal)


def test_the_rule_changes_its_mind_at_the_threshold(scripted_run: Make) -> None:
    folder = scripted_run(TASK, "run", near="F")
    run = read_run(folder)
    assert run.network is not None
    found = choice(folder, 3)
    threshold = found.options[1].threshold_s(found.way)
    assert threshold is not None
    for cost, first in ((threshold - 1e-6, 2), (threshold + 1e-6, 0)):
        planner = Planner(cheaper(run.network.network, 2, cost))
        planner.failed(planner.network.actions[0], "")
        plan = planner.plan("a")
        assert isinstance(plan, Plan)
        assert plan.actions[0].index == first


@pytest.mark.parametrize(
    ("policy", "words", "first"),
    [("expected_cost", "least expected price", 2), ("goal_probability", "largest probability", 2)],
)
def test_a_policy_is_explained_as_one(scripted_run: Make, policy: str, words: str, first: int) -> None:
    found = choice(scripted_run(TASK.replace("goal: z\n", f"goal: z\npolicy: {policy}\n", 1), "run"))
    assert found.chosen.index == first
    lines = list(choice_words(found))
    assert lines[0].startswith(words)
    assert not any("chosen below" in line for line in lines)
    chosen, other = (option.value for option in found.options)
    assert chosen is not None
    assert other is not None
    assert chosen.goal >= other.goal
