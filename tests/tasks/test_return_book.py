"""The task return_book, through `handcart run`'s own function and the generated libraries."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.books.library_files import Libraries
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.trial_run import run_trial
from tests.journals import timeless_records

ROOT = Path(__file__).resolve().parents[2]
TASK = ROOT / "tasks" / "return_book" / "task.yaml"


def trial(tmp_path: Path, seed: int, settings: dict[str, str] | None = None, **library: Any) -> Trial:
    worlds = Libraries.model_validate(library) if library else None
    return run_trial(CampaignSetting(TASK, None, settings, worlds, tmp_path), seed)


@pytest.mark.slow
def test_the_book_stands_in_its_place(tmp_path: Path) -> None:
    done = trial(tmp_path, 11)
    assert done.status == 0
    metrics = done.summary["metrics"]
    assert metrics["slot_correct"]
    assert abs(metrics["proud_mm"]) < 10.0
    assert metrics["tilt_deg"] < 5.0
    assert metrics["pushed_mm"] < 10.0
    assert metrics["labels_read"] > 15
    assert metrics["untrue"] == []


@pytest.mark.slow
def test_a_box_on_the_way_is_a_fail_then_another_way_is_found(tmp_path: Path) -> None:
    done = trial(tmp_path, 2, misplaced=True, blocked="way_around")
    assert done.status == 0
    assert done.summary["fails"] >= 1
    assert done.summary["replans"] >= 1
    assert done.untrue == []


@pytest.mark.slow
def test_without_a_route_robot_is_restored_and_place_is_named(tmp_path: Path) -> None:
    done = trial(tmp_path, 3, blocked="closed")
    assert done.status == 3
    assert done.summary["situation"] == "way_blocked"
    assert "no way around leads to shelf_" in done.summary["reason"]
    assert done.untrue == []


@pytest.mark.slow
def test_an_unknown_book_ends_with_status_3_and_a_reason(tmp_path: Path) -> None:
    """An unreadable tag and a missing gap do so in tests/tools/commands/test_explain.py."""
    done = trial(tmp_path, 4, tag="unknown")
    assert done.status == 3
    assert "not in the catalogue" in done.summary["reason"]
    assert done.untrue == []


@pytest.mark.slow
def test_n11_same_seed_same_journal_whatever_the_hash_seed(tmp_path: Path) -> None:
    journals = []
    for hash_seed in ("0", "99"):
        runs = tmp_path / hash_seed
        words = ["run", str(TASK), "--seed", "5", "--runs", str(runs), "--json"]
        code = f"from handcart.tools.main import main; main({words!r})"
        said = subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"PYTHONHASHSEED": hash_seed},
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
        report = json.loads(said.stdout.splitlines()[-1])
        assert {
            "outcome",
            "situation",
            "reason",
            "actions",
            "fails",
            "replans",
            "sim_time_s",
        } <= report.keys()
        assert {"wall_time_s", "seed", "backend", "run_dir", "metrics"} <= report.keys()
        folder = Path(report["run_dir"])
        assert (folder / "overview.svg").stat().st_size > 10_000
        journals.append(timeless_records(folder / "journal.jsonl"))
    assert journals[0] == journals[1]


@pytest.mark.slow
def test_two_books_one_after_the_other(tmp_path: Path) -> None:
    task = TASK.parent.parent / "return_books" / "task.yaml"
    done = run_trial(CampaignSetting(task, None, {"books": "[1, 2]"}, Libraries(books=2), tmp_path), 6)
    assert done.status == 0
    assert done.summary["actions"] == 16
    assert done.summary["metrics"]["slot_correct"]
    assert done.untrue == []
