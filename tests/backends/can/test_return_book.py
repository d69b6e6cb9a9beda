"""The whole task through CAN frames; one motion alone: test_cart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions


def run(folder: Path, backend: str, bench: str | None = None) -> tuple[Any, ...]:
    summary, status = run_task(
        LIBRARY_FOLDER / "task.yaml", folder, RunOptions(backend=backend, errors=False, bench=bench)
    )
    assert summary["metrics"]["untrue"] == []
    return (status, *(summary[name] for name in ("outcome", "situation", "reason", "actions", "fails")))


@pytest.mark.slow
@pytest.mark.parametrize("bench", ["kinematic", "mujoco"])
def test_errorless_run_on_the_bench_equals_its_backend(tmp_path: Path, bench: str) -> None:
    ended = run(tmp_path, bench)
    assert run(tmp_path, "can", bench) == ended
    assert ended[:2] == (0, "Success")
