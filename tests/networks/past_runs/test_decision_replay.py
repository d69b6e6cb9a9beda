"""Today's decisions on the outcomes of a past run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.graph.plan_search import PlanSearch
from handcart.networks.graph.planner import Planner
from handcart.networks.graph.route import RunDecisions
from handcart.networks.past_runs.decision_replay import DecisionReplay, replay_decisions
from handcart.networks.past_runs.past_run import read_run
from tests.networks.past_runs.conftest import TWO_WAYS_BACK as TASK

Make = Callable[..., Path]


def replayed(folder: Path) -> DecisionReplay:
    found = replay_decisions(read_run(folder))
    assert found is not None
    return found


@pytest.mark.parametrize(
    "script", [{}, {"near": "F"}, {"near": "FF"}, {"near": "P", "far": "FFF"}, {"ahead": "G"}]
)
def test_the_same_code_decides_the_same(scripted_run: Make, script: dict[str, str]) -> None:
    folder = scripted_run(TASK, "run", **script)
    found = replayed(folder)
    run = read_run(folder)
    assert found.difference is None
    assert found.plans == sum(record["kind"] == "PLAN" for record in run.records)
    assert found.actions == len(run.actions)


def test_other_weights_are_named_with_both_costs(scripted_run: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = scripted_run(TASK, "run", near="F")
    doubled = PlanSearch.weight
    monkeypatch.setattr(PlanSearch, "weight", lambda self, action, counts: doubled(self, action, {}))
    monkeypatch.setattr(Planner, "failed", lambda self, action, reason, *, permanent=False: None)
    found = replayed(folder)
    assert found.difference is not None
    assert (found.plans, found.actions) == (1, 1)
    words = found.difference.words()
    assert "the run planned THINK (c to a), THINK (a to b), THINK (b to z) for 6 s" in words
    assert "today's code plans THINK (c to a), THINK (a to b), THINK (b to z) for 4 s" in words
    assert "the route is the same" in words


def test_an_action_that_is_used_up_today_is_named(
    scripted_run: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = scripted_run(TASK, "run", near="F")
    count = Planner.failed

    def for_good(self: Any, action: Any, reason: str, *, permanent: bool = False) -> None:
        count(self, action, reason, permanent=True)

    monkeypatch.setattr(Planner, "failed", for_good)
    found = replayed(folder)
    assert found.difference is not None
    assert "THINK (a to b) is used up" in found.difference.why


def test_another_end_is_found(scripted_run: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = scripted_run(TASK, "run")
    monkeypatch.setattr(RunDecisions, "arrived", False)
    found = replayed(folder)
    assert found.difference is not None
    assert found.difference.words().startswith("record 6 at")
    assert "the run ended in z, today's code goes on" in found.difference.words()
