"""Counts of an action's ends and the interval of its mean duration, as they stand in a task file."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from handcart.evaluation.campaigns.learned.entry_counts import EntryCounts, count_entries
from handcart.evaluation.campaigns.learned.seen_actions import SeenActions
from handcart.evaluation.campaigns.walks.odds import EndCode
from handcart.networks.deciding.posterior import OutcomeCounts
from handcart.networks.entries.action_entry import ActionEntry
from handcart.networks.task.task_file import Task

ENTRY_COUNT = 2


def counted(monkeypatch: pytest.MonkeyPatch, ends: list[EndCode], seconds: list[float]) -> list[EntryCounts]:
    """Return the counts of a task of two actions, of which the first was tried with these ends."""
    none, count = np.zeros(0), len(ends)
    seen = SeenActions(
        np.arange(count),
        np.zeros(count, int),
        np.zeros(count, int),
        np.array(ends, int),
        np.array(seconds),
        none,
        none,
        none,
    )
    module = "handcart.evaluation.campaigns.learned.entry_counts"
    monkeypatch.setattr(f"{module}.action_names", lambda task: ["first", "second"])
    monkeypatch.setattr(SeenActions, "of", lambda task, trials: seen)
    entry = ActionEntry.model_validate({"do": "MOVE_TO", "from": "a", "to": "b", "cost_s": 1.0})
    task = SimpleNamespace(file=SimpleNamespace(actions=[entry] * ENTRY_COUNT))
    return count_entries(cast("Task", task), [])


def test_interval_of_a_mean_is_students(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = counted(monkeypatch, [EndCode.SUCCESS] * 4 + [EndCode.FAIL], [4.0, 5.0, 6.0, 7.0, 8.0])
    assert first.counts == OutcomeCounts(4, 1, 0)
    assert first.mean_s == 6.0
    reach = 2.776 * math.sqrt(2.5 / 5)  # Student's t at 0.975 with 4 degrees of freedom
    assert first.mean_95_s == pytest.approx((6.0 - reach, 6.0 + reach), abs=1e-3)
    assert second.counts == OutcomeCounts()
    assert math.isnan(second.mean_s)


def test_interval_of_two_durations_is_wide(monkeypatch: pytest.MonkeyPatch) -> None:
    first, _ = counted(monkeypatch, [EndCode.SUCCESS, EndCode.FAIL], [4.0, 6.0])
    assert first.mean_95_s == pytest.approx((0.0, 5.0 + 12.706), abs=1e-3)


def test_single_duration_has_no_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    first, _ = counted(monkeypatch, [EndCode.FOR_GOOD], [3.0])
    assert first.counts == OutcomeCounts(0, 1, 0)
    assert first.mean_s == 3.0
    assert np.isnan(first.mean_95_s).all()


def test_written_chances_are_never_certain_and_never_above_one() -> None:
    sure = EntryCounts(OutcomeCounts(100_000, 0, 0), {}, 1.0, (1.0, 1.0))
    assert (sure.p, sure.p_give_up) == (0.999, 0.0)
    half = EntryCounts(OutcomeCounts(50, 25, 25), {}, 1.0, (1.0, 1.0))
    assert half.p + half.p_give_up <= 1.0
    assert half.p_give_up == pytest.approx(0.25, abs=0.02)
    low, high = half.p_95
    assert low < 0.5 < high
