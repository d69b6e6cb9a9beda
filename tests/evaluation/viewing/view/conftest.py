"""One short run of a base on its tour, recorded."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TOUR = Path(__file__).parents[4] / "tasks" / "drive_map" / "task.yaml"
SETTINGS = {"robot": "cart", "tour": "[desk]"}


@pytest.fixture(scope="session")
def toured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    summary, status = run_task(
        TOUR, tmp_path_factory.mktemp("runs"), RunOptions(settings=SETTINGS, playback=True)
    )
    assert status == 0
    return Path(summary["run_dir"])
