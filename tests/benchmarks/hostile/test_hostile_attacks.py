"""Attacks are seen where they succeed: the watch over a process, and forged checksums."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from benchmarks.damage.folder_trial import Watch
from benchmarks.damage.forging import reseal
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal


@pytest.fixture
def watch(tmp_path: Path) -> Watch:
    for name in ("run", "outside"):
        (tmp_path / name).mkdir()
    return Watch([tmp_path / "run"], tmp_path / "outside", on=True)


def test_what_runs_or_touches_is_noted(watch: Watch, tmp_path: Path) -> None:
    (tmp_path / "run" / "link").symlink_to(tmp_path / "outside")
    writes = os.O_WRONLY | os.O_CREAT
    watch("open", (str(tmp_path / "run" / "mine"), "w", writes))
    watch("open", (str(tmp_path / "elsewhere"), "r", os.O_RDONLY))
    watch("os.remove", (b"state.bullet", 5))
    assert watch.seen == []
    watch("open", (str(tmp_path / "run" / "link" / "secret"), "r", os.O_RDONLY))
    watch("open", (str(tmp_path / "elsewhere"), "w", writes))
    watch("os.rename", (str(tmp_path / "run" / "mine"), str(tmp_path / "taken"), -1, -1))
    watch("os.system", (b"true",))
    watch("pickle.find_class", ("posix", "system"))
    assert [item.split(" was")[-1] if " was" in item else item.split()[0] for item in watch.seen] == [
        " opened",
        " written",
        " written",
        "os.system",
        "pickle.find_class",
    ]


def test_python_tells_of_what_is_watched() -> None:
    """The names of the audit events are Python's own."""
    script = (
        "import sys, os, subprocess\n"
        "seen = set(); sys.addaudithook(lambda event, words: seen.add(event))\n"
        "os.system('true'); subprocess.run(['true']); open(os.devnull, 'w').close()\n"
        "print(sorted(seen & {'os.system', 'subprocess.Popen', 'open'}))"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "['open', 'os.system', 'subprocess.Popen']"


def test_a_forged_journal_is_whole(tmp_path: Path) -> None:
    with Journal(tmp_path / "journal.jsonl") as journal:
        for number in range(3):
            journal.append("RUN", 0.0, {"n": number})

    def without_one(records: list[dict[str, Any]]) -> None:
        records.pop(1)

    reseal(tmp_path, without_one)
    assert [record["n"] for record in read_journal(tmp_path / "journal.jsonl").records] == [0, 2]
