"""return_book on a robot whose arm others described: not a line of code knows it."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

pytest.importorskip("pybullet_data", reason="the arm's URDF comes with PyBullet")

ROOT = Path(__file__).resolve().parents[2]
TASK = ROOT / "tasks" / "return_book" / "task.yaml"
CODE = ("robotics", "files", "backends", "primitives", "networks", "evaluation", "tools")


def test_no_line_of_code_knows_the_robot() -> None:
    links = ("xarm", "link_base", "joint1", "librarian")
    known = [
        (path.relative_to(ROOT), word)
        for folder in CODE
        for path in (ROOT / folder).rglob("*.py")
        for word in links
        if f'"{word}' in path.read_text(encoding="utf-8")
    ]
    defaults = {"librarian"}  # robot that commands use by default
    assert [item for item in known if item[1] not in defaults] == []


def test_its_hand_and_tray_are_elsewhere() -> None:
    own, other = load_robot("librarian"), load_robot("xarm_cart")
    assert other.finger_shape.tip == pytest.approx(own.finger_shape.tip + 0.01)
    assert other.tray_shape.middle != own.tray_shape.middle


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0])
def test_it_returns_a_book(tmp_path: Path, seed: int) -> None:
    summary, status = run_task(TASK, tmp_path, RunOptions(settings={"robot": "xarm_cart"}, seed=seed))
    assert (status, summary["outcome"], summary["fails"]) == (0, "Success", 0)
    assert summary["metrics"]["slot_correct"]
    assert summary["metrics"]["untrue"] == []


@pytest.mark.slow
def test_it_returns_a_book_in_physics(tmp_path: Path) -> None:
    """Its camera's pictures are the engine's."""
    world = tmp_path / "world.yaml"
    text = TASK.with_name("world.yaml").read_text(encoding="utf-8")
    world.write_text(f"{text}\ncamera: engine\n", encoding="utf-8")
    settings = {"robot": "xarm_cart", "world": str(world)}
    summary, status = run_task(TASK, tmp_path / "runs", RunOptions(backend="pybullet", settings=settings))
    assert (status, summary["outcome"]) == (0, "Success")
    assert summary["metrics"]["slot_correct"]
    assert summary["metrics"]["untrue"] == []
