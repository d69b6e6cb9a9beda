"""Seams on the command line: `handcart place`, and `handcart check` of a task that tracks one."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said

TASK = Path(__file__).resolve().parents[3] / "tasks" / "track_seam"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The shipped task, to be changed."""
    return Path(shutil.copytree(TASK, tmp_path / "seam"))


def lines(folder: Path) -> list[str]:
    return (folder / "seam.csv").read_text(encoding="utf-8").splitlines()


def write(folder: Path, rows: list[str]) -> Path:
    path = folder / "seam.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def raised(row: str, by: float) -> str:
    x, y, z, *rest = row.split(",")
    return ",".join((x, y, f"{float(z) + by:.4f}", *rest))


@pytest.mark.slow
def test_a_seam_that_can_be_tracked_is_told_with_its_division(handcart: Callable[..., Said]) -> None:
    said = handcart("check", TASK / "task.yaml")
    assert said.status == 0
    assert "seam: 5.13 m, 3 placements, score 0.6" in said.out


@pytest.mark.slow
def test_first_unreachable_point_is_reported_with_the_reach(
    handcart: Callable[..., Said], folder: Path
) -> None:
    head, *rows = lines(folder)
    high = [raised(row, min(0.03 * max(0, number - 50), 1.5)) for number, row in enumerate(rows)]
    path = write(folder, [head, *high])
    said = handcart("check", folder / "task.yaml", "--json")
    assert said.status == 2
    (finding,) = json.loads(said.out.splitlines()[-1])["findings"]
    assert finding["file"] == str(path)
    assert 55 < finding["line"] < 110
    # Before it is out of reach the arm is stretched, and too slow.
    assert finding["message"].startswith("this point is reached, but nowhere with 0.1 m/s and 60 N along")
    assert "; the nearest that can be reached: (" in finding["message"]


@pytest.mark.slow
def test_far_out_of_reach_the_nearest_is_told_too(handcart: Callable[..., Said], folder: Path) -> None:
    head, *rows = lines(folder)
    write(folder, [head, *(raised(row, 3.0) for row in rows)])
    said = handcart("check", folder / "task.yaml")
    assert said.status == 2
    assert "seam.csv:2:1: this point is out of the arm's reach, wherever the base stands" in said.err
    assert "; the nearest that can be reached: (" in said.err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[4, 3, 2, 1]", "[2, 1]", "is as far as 2 placements get; needed: 3"),
        ("robot: atrv", "robot: toolless.yaml", "DIVIDE can't be done: the robot's file has no tool"),
    ],
)
def test_what_else_is_in_the_way_is_told(
    handcart: Callable[..., Said], folder: Path, old: str, new: str, message: str
) -> None:
    robots = TASK.parents[1] / "backends" / "robots" / "atrv"
    shutil.copy(robots / "atrv.urdf", folder)
    text = (robots / "robot.yaml").read_text(encoding="utf-8")
    start, end = text.index("tool: "), text.index("errors: ")
    (folder / "toolless.yaml").write_text(text[:start] + text[end:], encoding="utf-8")
    task = folder / "task.yaml"
    task.write_text(task.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    said = handcart("check", task)
    assert said.status == 2
    assert message in said.err


@pytest.mark.slow
def test_placing_writes_a_task_that_holds(
    handcart: Callable[..., Said], folder: Path, tmp_path: Path
) -> None:
    head, *rows = lines(folder)
    path = write(folder, [head, *rows[:120]])
    out = tmp_path / "out"
    said = handcart("place", "atrv", path, "-o", out, "--work-piece", folder / "work_piece.yaml")
    assert said.status == 0
    assert " m of seam, 1 placements, score 0." in said.out
    assert (out / "placements.svg").read_text(encoding="utf-8").startswith("<?xml")
    assert handcart("check", out / "task.yaml").status == 0
    said = handcart("run", out / "task.yaml", "--json", "--runs", tmp_path / "runs")
    summary = json.loads(said.out.splitlines()[-1])
    assert (said.status, summary["metrics"]["placements"], summary["metrics"]["untrue"]) == (0, 1, [])


def test_placing_refuses_what_cannot_be_tracked(
    handcart: Callable[..., Said], folder: Path, tmp_path: Path
) -> None:
    head, *rows = lines(folder)
    path = write(folder, [head, *(raised(row, 2.0) for row in rows)])
    said = handcart("place", "atrv", path, "-o", tmp_path / "out")
    assert said.status == 2
    assert "seam.csv:2:1: this point is out of the arm's reach" in said.err
    assert "Traceback" not in said.err
