"""Tracking a long seam, as its user does."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASK = Path(__file__).parents[2] / "tasks" / "track_seam" / "task.yaml"


def world_with(folder: Path, surprise: str) -> dict[str, str]:
    """The shipped world with something that no map shows."""
    world = (TASK.parent / "world.yaml").read_text(encoding="utf-8")
    path = folder / "world.yaml"
    path.write_text(f"{world}surprises:\n  - {{{surprise}}}\n", encoding="utf-8")
    return {"world": str(path)}


@pytest.mark.slow
def test_five_metres_are_tracked_to_a_millimetre_from_three_places(tmp_path: Path) -> None:
    summary, status = run_task(TASK, tmp_path, RunOptions(seed=3))
    metrics = summary["metrics"]
    assert status == 0
    assert metrics["untrue"] == []
    assert metrics["placements"] == 3
    assert metrics["seam_tracked_m"] == pytest.approx(5.13, abs=0.01)
    assert 0.6 < metrics["score"] < 1.0
    assert metrics["tracking_error_mm_rms"] < metrics["tracking_error_mm_max"] < 1.3
    assert metrics["joint_limit_violations"] == 0
    assert summary["fails"] == 0


@pytest.mark.slow
def test_while_the_base_drives_along_the_tool_stays_on_the_seam(tmp_path: Path) -> None:
    summary, status = run_task(TASK.with_name("driving.yaml"), tmp_path, RunOptions(seed=1))
    metrics = summary["metrics"]
    assert status == 0
    assert metrics["untrue"] == []
    assert metrics["placements"] == 1
    assert metrics["seam_tracked_m"] == pytest.approx(5.13, abs=0.01)
    assert metrics["tracking_error_mm_max"] < 3.0
    assert metrics["joint_limit_violations"] == 0


@pytest.mark.slow
def test_a_way_that_is_blocked_is_left_for_places_to_stand_at(tmp_path: Path) -> None:
    box = "name: crate, x_m: 4.4, y_m: 2.7, size_m: [0.5, 0.5, 0.6]"
    options = RunOptions(settings=world_with(tmp_path, box))
    summary, status = run_task(TASK.with_name("driving.yaml"), tmp_path, options)
    metrics = summary["metrics"]
    assert (status, metrics["untrue"]) == (0, [])
    assert summary["fails"] >= 1
    assert metrics["seam_tracked_m"] == pytest.approx(5.13, abs=0.01)
    assert metrics["tracking_error_mm_max"] < 3.0


@pytest.mark.slow
def test_occupied_place_is_a_fail_and_the_rest_is_divided_again(tmp_path: Path) -> None:
    box = "name: crate, x_m: 4.4, y_m: 2.7, size_m: [0.5, 0.5, 0.6]"
    summary, status = run_task(TASK, tmp_path, RunOptions(settings=world_with(tmp_path, box)))
    metrics = summary["metrics"]
    assert metrics["untrue"] == []
    assert status == 0
    assert summary["fails"] >= 1
    assert metrics["seam_tracked_m"] == pytest.approx(5.13, abs=0.01)
    journal = (Path(summary["run_dir"]) / "journal.jsonl").read_text(encoding="utf-8")
    assert "place_4" in journal


@pytest.mark.slow
def test_a_base_that_is_not_known_exactly_tracks_nothing(tmp_path: Path) -> None:
    folder = TASK.parents[2] / "backends" / "robots" / "atrv"
    shutil.copy(folder / "atrv.urdf", tmp_path)
    text = (folder / "robot.yaml").read_text(encoding="utf-8").replace("sigma_mm: 0.3", "sigma_mm: 30.0")
    robot = tmp_path / "robot.yaml"
    robot.write_text(text, encoding="utf-8")
    summary, status = run_task(
        TASK, tmp_path, RunOptions(settings={"robot": str(robot), "places_left": "[3]"})
    )
    assert status == 3
    assert "the pose of the base isn't known exactly enough" in summary["reason"]
    assert summary["metrics"]["untrue"] == []


@pytest.mark.slow
def test_it_is_tracked_in_physics(tmp_path: Path) -> None:
    """The part of it that one placement reaches."""
    pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    task = Path(shutil.copytree(TASK.parent, tmp_path / "task")) / TASK.name
    rows = (task.with_name("seam.csv")).read_text(encoding="utf-8").splitlines()[:121]
    task.with_name("seam.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    summary, status = run_task(task, tmp_path / "runs", RunOptions(backend="pybullet"))
    metrics = summary["metrics"]
    assert (status, summary["fails"], metrics["untrue"]) == (0, 0, [])
    assert metrics["placements"] == 1
    assert metrics["tracking_error_mm_max"] < 1.5
    assert metrics["joint_limit_violations"] == 0
