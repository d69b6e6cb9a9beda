"""A full disk, simulated by a limit on the size of files (rows D5, D6, D10)."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from handcart.networks.journal.journal_record import read_journal
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def run_with(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> Callable[[str], subprocess.CompletedProcess[str]]:
    """Runs the tour where no file grows beyond the journal's records up to a kind, and a little more."""
    handcart("run", tour, "--runs", tmp_path / "whole")
    whole = tmp_path / "whole" / f"{tour.stem}-0" / "journal.jsonl"

    def run(kind: str) -> subprocess.CompletedProcess[str]:
        lines = whole.read_bytes().splitlines(keepends=True)
        before = [record["kind"] for record in read_journal(whole).records].index(kind)
        most = sum(map(len, lines[:before])) + 20
        return subprocess.run(
            [sys.executable, "-m", "handcart", "run", tour, "--runs", tmp_path / "runs", "--json"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
        )

    return run


@pytest.mark.slow
def test_full_before_the_start_nothing_moves(
    run_with: Callable[[str], subprocess.CompletedProcess[str]], tour: Path, tmp_path: Path
) -> None:
    """D5: the written records are complete, status 5."""
    said = run_with("START")
    assert said.returncode == 5
    assert "can't be written" in said.stderr
    assert "Traceback" not in said.stderr
    assert json.loads(said.stdout)["outcome"] == "Error"
    contents = read_journal(tmp_path / "runs" / f"{tour.stem}-0" / "journal.jsonl")
    assert [record["kind"] for record in contents.records] == ["RUN", "PLAN"]
    assert contents.torn_at is None


@pytest.mark.slow
def test_full_at_a_result_the_run_ends_and_tells_it(
    run_with: Callable[[str], subprocess.CompletedProcess[str]], tour: Path, tmp_path: Path
) -> None:
    """D6: that the outcome is not in the journal for good."""
    said = run_with("RESULT")
    assert said.returncode == 5
    assert "how action 1 ended is not in the journal for good" in said.stderr
    contents = read_journal(tmp_path / "runs" / f"{tour.stem}-0" / "journal.jsonl")
    assert [record["kind"] for record in contents.records] == ["RUN", "PLAN", "START"]


def test_a_folder_that_takes_no_file_is_refused_before_anything_moves(
    handcart: Callable[..., Said], tour: Path
) -> None:
    """D10"""
    said = handcart("run", tour, "--runs", "/proc/runs", "--json")
    assert said.status == 5
    assert "/proc" in said.err
    with pytest.raises(json.JSONDecodeError):
        json.loads(said.out)
