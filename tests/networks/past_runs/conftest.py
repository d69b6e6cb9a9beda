"""Runs whose actions end as a script says."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from handcart.networks.runs.run import execute
from handcart.networks.task.preparing import Prepared
from handcart.networks.task.task_file import load_task
from tests.networks.conftest import Stand


@pytest.fixture
def scripted_run(
    tmp_path: Path, new_stand: Callable[[], Stand], primitives: SimpleNamespace
) -> Callable[..., Path]:
    """Runs a task's text with scripted ends of its THINK actions, by their names; gives the run's folder."""

    def done(text: str, folder: str, **script: str) -> Path:
        stand = new_stand()
        for name, ends in script.items():
            stand.script[name] = deque(ends)
        path = tmp_path / "task" / "task.yaml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        task = load_task(path, {}, lambda name: getattr(primitives, name))
        prepared = Prepared(task, "two_wheels", stand.backend, stand.robot, stand.model, 7, {}, ())
        execute(prepared, tmp_path / folder)
        return tmp_path / folder

    return done


TWO_WAYS_BACK = """\
format: handcart-task/1
title: Two ways
robot: librarian
start: a
goal: z
situations: {a: {}, b: {}, c: {}, z: {}}
actions:
  - {do: THINK, from: a, to: b, cost_s: 2, attempts: 2, on_fail: c, with: {name: near}}
  - {do: THINK, from: b, to: z, cost_s: 1, with: {name: ahead}}
  - {do: THINK, from: a, to: z, cost_s: 6, with: {name: far}}
  - {do: THINK, from: c, to: a, cost_s: 1, with: {name: back}}
"""
