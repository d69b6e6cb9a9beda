"""Trials drawn as recorded campaigns show them, through the command."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import orjson
import pytest

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.data.walked_trials import network_trials
from tests.tools.conftest import Said

ASKED: dict[str, Any] = {"task": "walk.yaml", "level": "run", "shard": None, "first": 0, "trials": 200}


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """A campaign's folder with trials as if they had been run."""
    trials = network_trials(walk(tmp_path), {})
    with CampaignFolder.made(tmp_path / "recorded", ASKED).log() as log:
        log.append([trials.trial(seed) for seed in range(200)])
    return tmp_path / "recorded"


@pytest.mark.slow
def test_twenty_thousand_are_told_with_how_far_they_may_be_trusted(
    handcart: Callable[..., Said], recorded: Path
) -> None:
    task = recorded.parent / "walk.yaml"
    words = ("campaign", task, "--level", "fitted", "--learned-from", recorded, "--trials", 20_000)
    said = handcart(*words)
    assert said.status == 0, said.err
    successes = int(re.findall(r"Success (\d+) of 20000", said.out)[0])
    low, high = map(
        float, re.findall(r"learned from 200 trials.* bound it to ([\d.]+) to ([\d.]+) %", said.out)[0]
    )
    assert low < successes / 200 < high
    assert high - low > 1.0
    assert said.out.count("one half of them for the other") == 4
    facts = orjson.loads(handcart(*words[:-1], 50, "--json").out)
    assert facts["learned"]["trials"] == 200
    assert len(facts["learned"]["halves"]) == 4


@pytest.mark.slow
def test_what_is_kept_is_what_is_counted(
    handcart: Callable[..., Said], recorded: Path, tmp_path: Path
) -> None:
    words = ("campaign", recorded.parent / "walk.yaml", "--level", "fitted", "--learned-from", recorded)
    counted = handcart(*words, "--trials", 300)
    kept = handcart(*words, "--trials", 300, "--out", tmp_path / "out", "--jobs", 2)
    assert (counted.status, kept.status) == (0, 0)
    assert counted.out == kept.out
    assert "actions end as in" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    with CampaignFolder.read(recorded).log() as log:
        log.append(
            [network_trials(recorded.parent / "walk.yaml", {}).trial(seed) for seed in range(200, 210)]
        )
    other = handcart(*words, "--trials", 300, "--out", tmp_path / "out")
    assert (other.status, "trials learned from, 1" in other.err) == (2, True)


@pytest.mark.parametrize(
    ("words", "wrong"),
    [
        (("--level", "fitted"), "--level fitted and --learned-from; needed: both of them, or none"),
        (("--learned-from", "recorded"), "--level fitted and --learned-from; needed: both"),
        (("--level", "fitted", "--learned-from", "nowhere"), "nowhere"),
        (("--level", "fitted", "--learned-from", "recorded", "--vary", "v.yaml"), "don't vary with it"),
        (("--level", "fitted", "--learned-from", "recorded", "--generate", "library"), "has no world"),
        (("--level", "guessed"), "--level guessed; allowed: run, fitted, network"),
    ],
)
def test_what_cannot_be_is_refused(
    handcart: Callable[..., Said],
    recorded: Path,
    words: tuple[str, ...],
    wrong: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(recorded.parent)
    said = handcart("campaign", "walk.yaml", "--trials", 5, *words)
    assert (said.status, said.out) == (2, "")
    assert wrong in said.err
