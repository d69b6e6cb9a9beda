"""`handcart replay`: today's code on a past run."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from handcart.networks.graph.planner import Planner
from tests.tools.conftest import Said
from tests.tools.past_runs.conftest import TWO_WAYS as TASK

Make = Callable[..., Path]
Handcart = Callable[..., Said]


def test_equal_decisions_end_with_status_0(handcart: Handcart, scripted_run: Make) -> None:
    folder = scripted_run(TASK, "run", near="FF")
    assert handcart("replay", folder).out == "3 plans and 3 actions are the same\n"
    found = json.loads(handcart("replay", folder, "--json").out)
    assert (found["equal"], found["difference"]) == (True, None)


def test_another_decision_ends_with_status_3(
    handcart: Handcart, scripted_run: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = scripted_run(TASK, "run", near="F")
    monkeypatch.setattr(Planner, "failed", lambda self, action, reason, *, permanent=False: None)
    said = handcart("replay", folder)
    assert said.status == 3
    assert "today's code plans THINK (a to b), THINK (b to z) for 3 s" in said.out
    found = json.loads(handcart("replay", folder, "--json").out)
    assert found["difference"]["record"] == 4
    assert found["plans"] == 1


def test_a_run_without_readings_is_refused(handcart: Handcart, scripted_run: Make) -> None:
    said = handcart("replay", scripted_run(TASK, "run"), "--sensors")
    assert said.status == 2
    assert "needed: a run made with `handcart run --record-sensors`" in said.err
    assert handcart("replay", "nowhere").status == 2
