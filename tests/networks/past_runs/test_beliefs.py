"""Beliefs of a run: updated by outcomes, in the journal, explained, replayed, and restored by a resume."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from handcart.evaluation.viewing.explanation.explanation_words import choice_words
from handcart.files.errors import FileError
from handcart.networks.deciding.belief_planner import BeliefPlanner
from handcart.networks.deciding.beliefs import Beliefs
from handcart.networks.graph.belief_prior import BeliefPrior
from handcart.networks.journal.retracing import standing
from handcart.networks.past_runs.decision_replay import replay_decisions
from handcart.networks.past_runs.hindsight import choice_of
from handcart.networks.past_runs.past_run import PastRun, read_run
from handcart.networks.task.task_file import Task

TASK = """\
format: handcart-task/1
title: A short way with a trap
robot: librarian
policy: expected_cost
belief: {attempts: 10}
start: a
goal: z
situations: {a: {}, b: {}, stuck: {}, z: {}}
actions:
  - {do: THINK, from: a, to: z, cost_s: 10, on_fail: stuck, p: 0.98, with: {name: ahead}}
  - {do: THINK, from: a, to: b, cost_s: 12, p: 0.99, with: {name: around}}
  - {do: THINK, from: b, to: z, cost_s: 12, p: 0.99, with: {name: further}}
  - {do: THINK, from: stuck, to: z, cost_s: 500, p: 0.99, with: {name: back}}
repeat: {over: [1, 2, 3, 4], as: n, start: a, goal: z}
"""
Make = Callable[..., Path]


def names_of(run: PastRun) -> list[str]:
    """Return the actions that a run started, by their parameter `name`."""
    return [str(action.parameters["name"]) for action in run.actions]


def judged(run: PastRun) -> list[tuple[str, list[list[float]]]]:
    """Return the policy and the beliefs of each plan in the journal."""
    plans = [record["judged"] for record in run.records if record["kind"] == "PLAN"]
    return [(plan["follows"], plan["beliefs"]) for plan in plans]


def test_fails_of_other_copies_make_the_run_leave_the_rule(scripted_run: Make) -> None:
    """After two Fails ahead the way around is better in 95 % of draws, in elements that were not tried."""
    run = read_run(scripted_run(TASK, "run", ahead="FF"))
    assert names_of(run) == ["ahead", "back", "ahead", "back", "around", "further", "around", "further"]
    assert judged(run) == [
        ("rule", []),
        ("rule", [[0, 9.8, 1.2]]),
        ("expected_cost", [[0, 9.8, 2.2], [3, 10.9, 0.1]]),
    ]
    by_rule = read_run(scripted_run(TASK.replace("belief: {attempts: 10}\n", ""), "without", ahead="FF"))
    assert names_of(by_rule)[4] == "ahead"
    assert "judged" not in next(record for record in by_rule.records if record["kind"] == "PLAN")


def test_explain_names_belief_and_share_of_draws(scripted_run: Make) -> None:
    run = read_run(scripted_run(TASK, "run", ahead="FF"))
    words = {}
    for number in (3, 5):
        choice = choice_of(run, run.actions[number - 1])
        assert choice is not None
        words[number] = "\n".join(choice_words(choice))
    assert words[3].startswith("cheapest way to the goal")
    assert "of draws, by" in words[3]
    assert "needed to leave the rule: 95 %" in words[3]
    assert "THINK (a[2] to a[3]) is believed to succeed with p 0.891, by the file 0.98" in words[3]
    assert words[5].startswith("least expected price")
    assert "it is followed" in words[5]
    assert "is believed to succeed with p 0.817, by the file 0.98" in words[5]


def test_replay_judges_the_same_and_names_other_beliefs(scripted_run: Make) -> None:
    run = read_run(scripted_run(TASK, "run", ahead="FF"))
    found = replay_decisions(run)
    assert found is not None
    assert (found.plans, found.actions, found.difference) == (3, 8, None)
    changed = [
        {**record, "judged": {**record["judged"], "better": 0.5}} if record["kind"] == "PLAN" else record
        for record in run.records
    ]
    other = replay_decisions(replace(run, records=tuple(changed)))
    assert other is not None
    assert other.difference is not None
    assert "better in 50.0% of draws" in other.difference.words()


def test_a_journal_restores_the_beliefs(scripted_run: Make) -> None:
    """Also where it ends in the middle of an action: what has no end counts for nothing."""
    run = read_run(scripted_run(TASK, "run", ahead="FF"))
    assert run.network is not None
    network = run.network.network
    header = {**run.header, "network": network.fingerprint()}
    starts = [number for number, record in enumerate(run.records) if record["kind"] == "START"]
    for cut, beliefs in ((starts[1], ((0, 9.8, 1.2),)), (starts[4], ((0, 9.8, 2.2), (3, 11.9, 0.1)))):
        planner = standing(network, [header, *run.records[1 : cut + 1]]).route.planner
        assert isinstance(planner, BeliefPlanner)
        found = [item for belief in planner.beliefs.changed for item in belief]
        assert found == pytest.approx([item for belief in beliefs for item in belief])


@pytest.mark.parametrize("wrong", ["belief: {attempts: 0.5}", "belief: {weight: 3}"])
def test_a_wrong_belief_is_refused(load: Callable[..., Task], wrong: str) -> None:
    with pytest.raises(FileError):
        load(TASK.replace("belief: {attempts: 10}", wrong))


def test_a_look_renews_the_belief(load: Callable[..., Task]) -> None:
    """Fails before a look say nothing about what follows it; the look has a belief of its own."""
    text = TASK.replace("on_fail: stuck, p: 0.98", "attempts: {most: 3, fresh_after: DRIVE}, p: 0.98")
    task = load(text.replace("repeat:", "  - {do: DRIVE, from: a, to: a, cost_s: 1, p: 0.9}\nrepeat:"))
    prior = BeliefPrior.of(10.0, task.entries)
    assert prior is not None
    beliefs = Beliefs(task.network, prior)
    ahead = [item for item in task.network.actions if item.cost_s == 10.0]
    look = next(item for item in task.network.actions if item.do == "DRIVE" and item.source == "a[1]")
    for action in ahead[:2]:
        beliefs.failed(action)
    beliefs.succeeded(ahead[3])
    assert beliefs.weights(0) == pytest.approx((10.8, 2.2, 0.0))
    assert len({beliefs.chances()[item.index] for item in ahead}) == 1
    beliefs.succeeded(look)
    assert beliefs.weights(0) == pytest.approx((9.8, 0.2, 0.0))
    assert beliefs.weights(4) == pytest.approx((10.0, 1.0, 0.0))
