"""Stacking blocks, as its user does."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASKS = Path(__file__).parents[2] / "tasks"
UNLOAD = TASKS / "stack_blocks" / "unload.yaml"
BESIDE = {
    "world": str(TASKS / "stack_blocks" / "servo_world.yaml"),
    "building": str(TASKS / "stack_blocks" / "servo_building.yaml"),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "most"),
    [
        ({"robot": "toyama/h1"}, 1.3),
        ({}, 1.8),
        ({"robot": "toyama/h1", "method": "servo", **BESIDE}, 0.8),
    ],
    ids=["better arm", "the paper's arm", "a landmark beside each goal"],
)
def test_five_blocks_stand_in_a_row(tmp_path: Path, settings: dict[str, str], most: float) -> None:
    summary, status = run_task(UNLOAD, tmp_path, RunOptions(settings=settings, seed=4))
    metrics = summary["metrics"]
    assert status == 0
    assert metrics["untrue"] == []
    assert metrics["blocks_placed"] == 5
    assert metrics["raw_error_mm_max"] < most
    assert metrics["raw_error_mm_mean"] <= metrics["raw_error_mm_max"]
    assert metrics["frames"] >= 2
    assert "processed_error_mm_max" not in metrics  # that is for a method which corrects nothing


@pytest.mark.slow
def test_of_five_landmarks_beside_each_other_the_right_one_is_taken(tmp_path: Path) -> None:
    """The base stops so far off that the next block's landmark is nearer to the middle of the picture."""
    settings = {"robot": "toyama/h1", "method": "servo", **BESIDE}
    summary, status = run_task(UNLOAD, tmp_path, RunOptions(settings=settings, seed=153))
    assert status == 0
    assert summary["fails"] == 0
    assert summary["metrics"]["blocks_placed"] == 5


@pytest.mark.slow
def test_the_papers_method_errs_by_turn_and_lean(tmp_path: Path) -> None:
    settings = {"method": "fix_once", "rule": "paper"}
    metrics = run_task(UNLOAD, tmp_path, RunOptions(settings=settings))[0]["metrics"]
    along = [abs(block["x"]) for block in metrics["blocks"]]
    assert along[4] > 1.0 + along[0]
    assert metrics["processed_error_mm_max"] < metrics["raw_error_mm_max"] - 0.5
    assert all(block["read_x"] * 2 == round(block["read_x"] * 2) for block in metrics["blocks"])


@pytest.mark.slow
def test_carry_transport_and_stack(tmp_path: Path) -> None:
    summary, status = run_task(
        TASKS / "stack_blocks" / "task.yaml", tmp_path, RunOptions(settings={"robot": "toyama/h1"}, seed=1)
    )
    assert status == 0
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["raw_error_mm_max"] < 2.5


@pytest.mark.slow
def test_a_fence_of_three_rows(tmp_path: Path) -> None:
    summary, status = run_task(
        TASKS / "build_fence" / "task.yaml", tmp_path, RunOptions(settings={"robot": "toyama/h1"}, seed=1)
    )
    assert status == 0
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["blocks_placed"] == 15
