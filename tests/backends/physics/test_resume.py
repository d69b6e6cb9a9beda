"""A run in physics that was killed goes on from its checkpoint (rows K1, K2)."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.networks.journal.journal_record import read_journal
from tests.take_book import write_take_book

ROOT = Path(__file__).resolve().parents[3]
LONGEST = 300.0  # [s] of wall-clock time that a run gets


def handcart(*words: object) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "handcart", *map(str, words)]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)


def ended(process: subprocess.Popen[bytes]) -> dict[str, Any]:
    """Return the summary that a resumed run prints at its end."""
    out, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 0
    summary: dict[str, Any] = orjson.loads(out.splitlines()[-1])
    return summary


def results(folder: Path) -> list[tuple[int, str]]:
    """Number and outcome of each action that has ended."""
    path = folder / "journal.jsonl"
    records = read_journal(path).records if path.exists() else []
    return [(record["n"], record["outcome"]) for record in records if record["kind"] == "RESULT"]


@pytest.mark.slow
def test_killed_while_it_takes_the_book_it_takes_it_after_all(
    physics: type[PhysicsBackend], tmp_path: Path
) -> None:
    task = write_take_book(tmp_path)
    folder = tmp_path / "runs" / f"{tmp_path.name}-0"
    process = handcart("run", task, "--backend", physics.name, "--runs", folder.parent)
    end = time.monotonic() + LONGEST
    while not results(folder):
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.02)
    process.kill()
    process.communicate()
    assert results(folder) == [(1, "Success")]
    summary = ended(handcart("resume", folder, "--json"))
    assert (summary["outcome"], summary["situation"]) == ("Success", "in_hand")
    assert summary["metrics"].get("untrue", []) == []
    taken = results(folder)[1:]  # number 2, or 3 where 2 had begun when it was killed
    assert [outcome for _, outcome in taken] == ["Success"]
