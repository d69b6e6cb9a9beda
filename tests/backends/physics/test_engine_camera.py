"""Perception looks at pictures that another program draws than the one it grew up with."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASKS = Path(__file__).parents[3] / "tasks"


@pytest.mark.slow
@pytest.mark.parametrize("task", ["return_book", "stack_blocks"])
def test_tasks_succeed_with_the_engines_camera(
    physics: type[PhysicsBackend], tmp_path: Path, task: str
) -> None:
    world = tmp_path / "world.yaml"
    text = (TASKS / task / "world.yaml").read_text(encoding="utf-8")
    world.write_text(f"{text}\ncamera: engine\n", encoding="utf-8")
    options = RunOptions(backend=physics.name, settings={"world": str(world)}, seed=1)
    summary, status = run_task(TASKS / task / "task.yaml", tmp_path / "runs", options)
    assert (status, summary["outcome"], summary["metrics"]["untrue"]) == (0, "Success", [])
