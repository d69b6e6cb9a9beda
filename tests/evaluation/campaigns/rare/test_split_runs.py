"""Runs that are taken on from their checkpoints, again and again."""

from __future__ import annotations

import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest

from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.evaluation.campaigns.rare.level_stop import NotSplit
from handcart.evaluation.campaigns.rare.rare_event import RareEvent
from handcart.evaluation.campaigns.rare.rare_trial import run_population
from handcart.evaluation.campaigns.rare.split_runs import BrokenRun, SplitRuns
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.runs.run_options import RunOptions

LIKELY = {"likely": "0.5"}


def runs_of(task: Path, folder: Path, settings: Mapping[str, str], **event: Any) -> SplitRuns:
    options = RunOptions(settings=settings, interrupts=Interrupts())
    (folder / "live").mkdir(parents=True)
    return SplitRuns(task, options, RareEvent("GiveUp", **event), 0, folder / "live", folder)


@pytest.mark.slow
def test_what_comes_after_the_checkpoint_is_drawn_anew(tosses: Path, tmp_path: Path) -> None:
    runs = runs_of(tosses, tmp_path / "runs", LIKELY)
    assert 0 < runs.advance(1, 6).reached < 6
    level = runs.advance(2, np.zeros(24, dtype=np.intp))
    assert 4 < level.reached < 20  # half of them are likely; all or none if all continued as the first did
    assert level.steps == 24
    folders = sorted((tmp_path / "runs" / "live").glob("branch-*"))
    assert len(folders) == level.reached
    firsts = {next(entry["h"] for entry in journal(one) if entry["kind"] == "RESULT") for one in folders}
    assert len(firsts) == 1


def journal(folder: Path) -> list[Mapping[str, Any]]:
    return [orjson.loads(line) for line in (folder / "journal.jsonl").read_bytes().splitlines()]


@pytest.mark.slow
def test_a_population_is_the_same_again_and_leaves_what_ended_so(tosses: Path, tmp_path: Path) -> None:
    event = RareEvent("GiveUp", runs=8)
    options = RunOptions(settings=LIKELY, interrupts=Interrupts())
    one, again = (run_population(tosses, tmp_path / name, options, event, 5) for name in ("one", "again"))
    assert one.summary == again.summary
    metrics = one.summary["metrics"]
    levels = metrics["levels"]
    assert metrics["probability"] > 0.0
    assert [level[0] for level in levels] == [8] * 4
    assert [level[2] for level in levels[:3]] == [0, 0, 0]
    kept = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert kept == sorted(metrics["runs_kept"])
    for name in kept:
        folder = tmp_path / "one" / name
        assert orjson.loads((folder / "summary.json").read_bytes())["outcome"] == "GiveUp"
        results = [entry["outcome"] for entry in journal(folder) if entry["kind"] == "RESULT"]
        assert results == ["Fail", "Fail", "Fail", "GiveUp"]


@pytest.mark.slow
def test_attempts_of_one_action_may_be_what_says_nearer(tosses: Path, tmp_path: Path) -> None:
    runs = runs_of(tosses, tmp_path / "runs", {"likely": "0.999"}, importance="attempts", runs=2)
    assert [runs.advance(1, 2)[1:3], *(runs.advance(level, np.arange(2))[1:3] for level in (2, 3, 4))] == [
        (2, 0),
        (2, 0),
        (2, 0),
        (0, 2),
    ]


def test_a_run_that_cannot_be_put_back_is_refused(
    tosses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "handcart.backends.simulation.simulated_backend.SimulatedBackend.state", lambda _: None
    )
    runs = runs_of(tosses, tmp_path / "runs", {})
    with pytest.raises(NotSplit, match="allowed: a simulated one that can be put back"):
        runs.advance(1, 1)


def test_a_fault_of_our_own_is_no_end_that_counts(
    tosses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_self: object, _seconds: float = 0.0) -> None:
        raise TypeError("ours")

    monkeypatch.setattr("handcart.backends.kinematic.kinematic_backend.KinematicBackend.step", broken)
    runs = runs_of(tosses, tmp_path / "runs", {})
    with pytest.raises(BrokenRun, match="ended with Error: TypeError: ours"):
        runs.advance(1, 1)


def test_an_interrupt_ends_a_population(
    tosses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Interrupts() as heard:
        options = RunOptions(settings=LIKELY, interrupts=heard)
        step = KinematicBackend.step

        def interrupted(self: KinematicBackend) -> None:
            signal.raise_signal(signal.SIGINT)
            step(self)

        monkeypatch.setattr(KinematicBackend, "step", interrupted)
        with pytest.raises(KeyboardInterrupt):
            run_population(tosses, tmp_path / "runs", options, RareEvent("GiveUp", runs=50), 0)
    assert list((tmp_path / "runs").iterdir()) == []
