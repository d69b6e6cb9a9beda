"""Perception looks at pictures that another program draws than the one it grew up with."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASKS = Path(__file__).parents[3] / "tasks"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "shown"), [("return_book/task", "world"), ("stack_blocks/unload", "unload_world")]
)
def test_tasks_succeed_with_the_engines_camera(
    physics: type[PhysicsBackend], tmp_path: Path, task: str, shown: str
) -> None:
    path, world = TASKS / f"{task}.yaml", tmp_path / "world.yaml"
    text = (path.parent / f"{shown}.yaml").read_text(encoding="utf-8")
    world.write_text(f"{text}\ncamera: engine\n", encoding="utf-8")
    options = RunOptions(backend=physics.name, settings={"world": str(world)}, seed=1)
    summary, status = run_task(path, tmp_path / "runs", options)
    assert (status, summary["outcome"], summary["metrics"]["untrue"]) == (0, "Success", [])
