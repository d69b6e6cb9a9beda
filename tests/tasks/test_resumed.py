"""Tests of a killed and resumed run: it reports all of its parts, not the last one alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.trials.running import resume_task, run_task
from handcart.networks.runs.run_options import RunOptions
from tests.conftest import Copier

TASKS = Path(__file__).parents[2] / "tasks"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "after", "settings"),
    [
        ("return_book/task.yaml", 4, {}),
        ("stack_blocks/unload.yaml", 5, {"method": "fix_once", "look": "false"}),
        ("track_seam/task.yaml", 3, {}),
    ],
    ids=["book", "blocks", "seam"],
)
def test_its_metrics_are_those_of_a_run_that_was_not_killed(
    tmp_path: Path, copier: type[Copier], task: str, after: int, settings: dict[str, str]
) -> None:
    left = tmp_path / "left"
    copying = copier(after, left)
    whole, _ = run_task(
        TASKS / task,
        tmp_path / "runs",
        RunOptions(settings=settings, seed=2, checkpoints=True, observers=(copying,)),
    )
    again, status = resume_task(left, None, RunOptions(observers=(copier(0, left),)))
    assert status == 0
    assert again["metrics"] == whole["metrics"]
    assert again["metrics"]["untrue"] == []
