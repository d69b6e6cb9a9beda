"""`handcart wall`."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import check
from handcart.tools.blocks.wall import wall
from tests.primitives.blocks.drawings import drawing_file

CHART = Path(__file__).parents[3] / "tasks" / "build_wall" / "map.yaml"


def _chart(folder: Path) -> Path:
    """Return a copy of the map whose picture's name occurs in other words of the file too."""
    shutil.copyfile(CHART.parent / "map.png", folder / "n")
    (folder / "chart.yaml").write_text(CHART.read_text().replace("map.png", "n"))
    return folder / "chart.yaml"


@pytest.mark.slow
def test_a_drawn_wall_becomes_a_task_that_builds_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wall("toyama/h1", drawing_file(tmp_path), _chart(tmp_path), tmp_path / "task")
    said = capsys.readouterr().out
    assert "3 blocks, 3 trips" in said
    assert f"run it: handcart run {tmp_path / 'task' / 'task.yaml'}" in said
    assert check(tmp_path / "task" / "task.yaml").errors == ()
    summary, status = run_task(tmp_path / "task" / "task.yaml", tmp_path / "runs", RunOptions(seed=1))
    assert status == 0
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["contacts_unmeant"] == 0
    assert summary["metrics"]["raw_error_mm_max"] < 0.9
