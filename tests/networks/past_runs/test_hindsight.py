"""Alternatives to a past action, computed from the journal alone."""

import shutil
from collections import deque
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import TypeVar

import pytest

from handcart.evaluation.viewing.explanation.explanation_words import choice_words
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.planner import SKIP_WEIGHT
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.past_runs.hindsight import choice_of
from handcart.networks.past_runs.journaled_network import network_of
from handcart.networks.past_runs.past_run import PastRun, read_run
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_header import network_fields
from handcart.networks.task.preparing import Prepared
from handcart.networks.task.task_file import load_task
from tests.networks.conftest import Stand
from tests.networks.past_runs.conftest import TWO_WAYS_BACK as TASK

Known = TypeVar("Known")
REPEAT = """\
format: handcart-task/1
title: Three times
robot: librarian
start: a
goal: z
situations: {a: {}, b: {}, z: {}}
actions:
  - {do: THINK, from: a, to: b, cost_s: 2, attempts: 1, with: {name: {each: one}}}
  - {do: THINK, from: b, to: z, cost_s: 1, with: {name: home}}
repeat: {over: [x, y, w], as: one, start: a, goal: b, unfinished: skip}
"""


def known(what: Known | None) -> Known:
    assert what is not None
    return what


@pytest.fixture
def run(
    tmp_path: Path, new_stand: Callable[[], Stand], primitives: SimpleNamespace
) -> Callable[..., tuple[PastRun, ActionNetwork]]:
    """Runs a task with scripted ends; the folder is then all that is left."""

    def done(text: str, **script: str) -> tuple[PastRun, ActionNetwork]:
        stand = new_stand()
        for name, ends in script.items():
            stand.script[name] = deque(ends)
        path = tmp_path / "task" / "task.yaml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        task = load_task(path, {}, lambda name: getattr(primitives, name))
        execute(
            Prepared(task, "two_wheels", stand.backend, stand.robot, stand.model, 7, {}, ()), tmp_path / "run"
        )
        shutil.rmtree(path.parent)
        return read_run(tmp_path / "run"), task.network

    return done


def test_the_other_ways_cost_what_they_cost_then(run: Callable[..., tuple[PastRun, ActionNetwork]]) -> None:
    past, _ = run(TASK, near="F")
    first, _, second, third = past.actions
    choice = known(choice_of(past, first))
    assert choice.way.cost == 3.0
    assert [(option.weight, known(option.way).cost) for option in choice.options] == [(2.0, 3.0), (6.0, 6.0)]
    assert known(choice.next_best).cost == 6.0
    assert [[action.index for action in fail.way.actions] for fail in choice.after_fails] == [[3, 0, 1]]
    again = known(choice_of(past, second))
    assert (again.chosen.index, again.way.cost) == (0, 5.0)
    assert [(option.weight, option.fails) for option in again.options] == [(4.0, 1), (6.0, 0)]
    assert third.index == 1


def test_routes_after_a_fail_are_those_of_its_cause(
    run: Callable[..., tuple[PastRun, ActionNetwork]],
) -> None:
    by_cause = "{blocked: c, slipped: {to: b}, else: a}"
    past, _ = run(TASK.replace("on_fail: c,", f"on_fail: {by_cause},"))
    after = known(choice_of(past, past.actions[0])).after_fails
    assert [(fail.cause, fail.situation, fail.way.cost) for fail in after] == [
        ("", "a", 5.0),
        ("blocked", "c", 6.0),
        ("slipped", "b", 1.0),
    ]
    shutil.rmtree(past.folder)
    past, _ = run(TASK.replace("on_fail: c,", "on_fail: {blocked: c},"))
    choice = known(choice_of(past, past.actions[0]))
    assert [fail.cause for fail in choice.after_fails] == ["blocked"]
    assert list(choice_words(choice))[-1].startswith("a Fail by blocked leads to c, then 6 s from the goal")


def test_what_was_used_up_is_told(run: Callable[..., tuple[PastRun, ActionNetwork]]) -> None:
    past, _ = run(TASK, near="FF")
    choice = known(choice_of(past, past.actions[-1]))
    assert choice.chosen.index == 2
    assert choice.options[1].out == "used up: failed 2 of 2 times"
    assert choice.next_best is None


def test_what_failed_for_good_is_told(run: Callable[..., tuple[PastRun, ActionNetwork]]) -> None:
    past, _ = run(TASK, near="P")
    assert known(choice_of(past, past.actions[-1])).options[1].out == "used up: failed for good"


def test_plans_are_those_of_the_run(run: Callable[..., tuple[PastRun, ActionNetwork]]) -> None:
    for script in ({"near": "F"}, {"near": "FF", "far": "FF"}, {"ahead": "FF"}):
        past, _ = run(TASK, **script)
        costs = [record["cost"] for record in past.records if record["kind"] == "PLAN" and "cost" in record]
        planned = {}
        for record in past.records:
            if record["kind"] == "PLAN" and "cost" in record:
                planned["next"] = record
            if record["kind"] == "START" and "next" in planned:
                plan, action = planned.pop("next"), past.actions[record["n"] - 1]
                choice = known(choice_of(past, action))
                assert choice.way.cost == plan["cost"]
                assert [item.index for item in choice.way.actions] == plan["way"]
        assert costs
        shutil.rmtree(past.folder)


def test_leaving_an_element_undone_is_an_option(run: Callable[..., tuple[PastRun, ActionNetwork]]) -> None:
    past, network = run(REPEAT, x="F")
    choice = known(choice_of(past, past.actions[0]))
    skip = next(option for option in choice.options if option.action.binding is None)
    assert skip.weight == SKIP_WEIGHT
    kept = network_of(network_fields(network))
    assert [str(action) for action in kept.network.actions] == [str(action) for action in network.actions]


def test_a_person_is_needed(run: Callable[..., tuple[PastRun, ActionNetwork]]) -> None:
    past, _ = run(TASK, ahead="G")
    assert known(past.end)["outcome"] == "GiveUp"
    assert known(past.last_fail).result["cause"] == [
        {"reason": "ahead needs help", "kind": "unnamed", "check": "motion", "calls": ["Think.motion"]}
    ]


def test_last_fail_is_the_latest_and_a_resumed_run_is_not_ended(
    run: Callable[..., tuple[PastRun, ActionNetwork]], tmp_path: Path
) -> None:
    past, _ = run(TASK, near="FF", far="F")
    assert [action.outcome for action in past.actions].count("Fail") == 3
    assert (known(past.last_fail).number, known(past.last_fail).do) == (len(past.actions) - 1, "THINK")
    assert known(past.end)["outcome"] == "Success"
    path = tmp_path / "run" / "journal.jsonl"
    with Journal.go_on(path, read_journal(path), "never") as journal:
        journal.append("EPOCH", 9.0, {"after": past.records[-1]["q"], "in_doubt": None})
    assert read_run(tmp_path / "run").end is None


RETURNING = """\
format: handcart-task/1
title: A route on, though the cheapest one comes back
robot: librarian
start: a
goal: z
situations: {a: {}, b: {}, c: {}, z: {}}
actions:
  - {do: THINK, from: a, to: z, cost_s: 5, with: {name: near}}
  - {do: THINK, from: a, to: b, cost_s: 1, with: {name: aside}}
  - {do: THINK, from: b, to: a, cost_s: 1, with: {name: back}}
  - {do: THINK, from: b, to: z, cost_s: 90, with: {name: far}}
  - {do: THINK, from: a, to: c, cost_s: 1, with: {name: blind}}
  - {do: THINK, from: c, to: a, cost_s: 1, with: {name: out}}
"""


def test_an_alternative_that_leads_on_has_its_route(
    run: Callable[..., tuple[PastRun, ActionNetwork]],
) -> None:
    past, _ = run(RETURNING)
    near, aside, blind = known(choice_of(past, past.actions[0])).options
    assert known(near.way).cost == 5.0
    assert ([action.index for action in known(aside.way).actions], known(aside.way).cost) == ([1, 3], 91.0)
    assert (blind.way, blind.out) == (None, "leads only back here")
