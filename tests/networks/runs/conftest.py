"""A real robot's run of three actions, to be broken off at any record."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.runs.checkpoint import CHECKPOINT_FILE
from handcart.networks.runs.resuming import Past, read_past
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared
from handcart.networks.task.task_file import load_task
from tests.networks.conftest import Stand

TASK = """\
format: handcart-task/1
title: Drive three times
robot: librarian
start: a
goal: z
situations: {a: {}, b: {}, c: {}, z: {}}
actions:
  - {do: DRIVE, from: a, to: b, cost_s: 1, with: {periods: 4}}
  - {do: DRIVE, from: b, to: c, cost_s: 1, with: {periods: 6}}
  - {do: DRIVE, from: c, to: z, cost_s: 1, with: {periods: 8}}
  - {do: DRIVE, from: a, to: z, cost_s: 9, with: {periods: 8}}
"""


class UnfinishedRun:
    """A real robot's run, over: its folder and network, and the state from which it would resume."""

    def __init__(self, folder: Path, prepare: Callable[[], Prepared]) -> None:
        self.folder, self.prepare = folder, prepare
        prepared = prepare()
        self.network, self.model = prepared.task.network, prepared.model
        execute(prepared, folder, RunOptions(checkpoints=True, sync=False))

    @property
    def records(self) -> tuple[Any, ...]:
        return read_journal(self.folder / "journal.jsonl").records

    def cut(self, kind: str, number: int, half: bool = False) -> None:
        """Broken off before the `number`-th record of a kind, or in the middle of it."""
        path = self.folder / "journal.jsonl"
        lines = path.read_bytes().splitlines(keepends=True)
        place = [i for i, line in enumerate(lines) if f'"kind":"{kind}"'.encode() in line][number]
        torn = lines[place][: len(lines[place]) // 2] if half else b""
        path.write_bytes(b"".join(lines[:place]) + torn)

    def append(self, kind: str, **fields: Any) -> None:
        path = self.folder / "journal.jsonl"
        with Journal.go_on(path, read_journal(path), "never") as journal:
            journal.append(kind, 9.0, fields)

    def forget(self) -> None:
        (self.folder / CHECKPOINT_FILE).unlink()

    def past(self) -> Past:
        return read_past(self.folder, self.network)


@pytest.fixture
def run(tmp_path: Path, new_stand: Callable[[], Stand], primitives: SimpleNamespace) -> UnfinishedRun:
    path = tmp_path / "task" / "task.yaml"
    path.parent.mkdir()
    path.write_text(TASK)
    task = load_task(path, {}, lambda name: getattr(primitives, name))

    def prepare() -> Prepared:
        stand = new_stand()
        stand.backend.simulated = False
        return Prepared(task, "two_wheels", stand.backend, stand.robot, stand.model, 7, {}, ())

    return UnfinishedRun(tmp_path / "run", prepare)
