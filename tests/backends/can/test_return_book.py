"""A task through CAN frames: the whole, and a part of it in physics; one motion alone: test_cart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from tests.take_book import write_take_book


def run(task: Path, folder: Path, backend: str, bench: str | None = None) -> tuple[Any, ...]:
    summary, status = run_task(task, folder, RunOptions(backend=backend, errors=False, bench=bench))
    assert summary["metrics"].get("untrue", []) == []
    return (status, *(summary[name] for name in ("outcome", "situation", "reason", "actions", "fails")))


@pytest.mark.slow
@pytest.mark.parametrize("bench", ["kinematic", "mujoco"])
def test_errorless_run_on_the_bench_equals_its_backend(tmp_path: Path, bench: str) -> None:
    task = LIBRARY_FOLDER / "task.yaml" if bench == "kinematic" else write_take_book(tmp_path)
    ended = run(task, tmp_path / "runs", bench)
    assert run(task, tmp_path / "runs", "can", bench) == ended
    assert ended[:2] == (0, "Success")
