"""Perception looks at pictures that another program draws than the one it grew up with."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASKS = Path(__file__).parents[3] / "tasks"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("backend", "task", "shown"),
    [("mujoco", "return_book/task", "world"), ("pybullet", "stack_blocks/unload", "unload_world")],
)
def test_tasks_succeed_with_the_engines_camera(tmp_path: Path, backend: str, task: str, shown: str) -> None:
    """One task with each engine; tests/tasks/test_other_robots.py has PyBullet's camera on books."""
    if backend == "pybullet":
        pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    path, world = TASKS / f"{task}.yaml", tmp_path / "world.yaml"
    text = (path.parent / f"{shown}.yaml").read_text(encoding="utf-8")
    world.write_text(f"{text}\ncamera: engine\n", encoding="utf-8")
    options = RunOptions(backend=backend, settings={"world": str(world)}, seed=1)
    summary, status = run_task(path, tmp_path / "runs", options)
    assert (status, summary["outcome"], summary["metrics"]["untrue"]) == (0, "Success", [])
