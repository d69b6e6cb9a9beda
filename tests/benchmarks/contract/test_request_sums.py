"""The benchmark of requests tells what it found, however it ends."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from benchmarks.contract import requests
from benchmarks.cut_off import CUT_OFF_STATUS


def test_the_sum_names_each_kind_of_fault() -> None:
    counts = Counter({"right": 5, "eaten": 2, "died": 1, "give up": 3})
    assert requests.sum_line(counts) == (
        "11 requests, {'eaten': 2, 'doubled': 0, 'misapplied': 0, 'died': 1}; gave up 3"
    )


@pytest.mark.parametrize(("word", "misapplied"), [("right", 0), ("misapplied", 1)])
def test_it_reports_on_the_requests_before_an_interrupt(
    word: str, misapplied: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(campaign: Any, periods: set[int]) -> None:
        campaign.found[word] += 1
        raise KeyboardInterrupt

    monkeypatch.setattr(sys, "argv", ["requests"])
    monkeypatch.setattr(requests, "declared", lambda: {Path("drive_map/task.yaml"): {}})
    monkeypatch.setattr(requests.Campaign, "spans", lambda _: {1: (0, 9)})
    monkeypatch.setattr(requests.Campaign, "ask_in", interrupted)
    assert requests.main() == CUT_OFF_STATUS
    said = capsys.readouterr().out
    assert f"1 actions, 1 requests: {{'{word}': 1}}" in said
    assert f"1 requests, {{'eaten': 0, 'doubled': 0, 'misapplied': {misapplied}, 'died': 0}}" in said
