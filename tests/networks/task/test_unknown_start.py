"""Tasks whose start is unknown: LOCATE comes first, and what it needs is checked beforehand."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.files.errors import FileError
from handcart.networks.graph.planner import NoWay, Planner
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import check, prepare
from handcart.networks.task.task_file import load_task
from handcart.networks.task.unknown_start import NotLocated, drawn_pose
from handcart.primitives.knowledge.place import load_map

DRIVE_MAP = Path(__file__).parents[3] / "tasks" / "drive_map"
TASK = DRIVE_MAP / "task.yaml"
UNKNOWN = {"start": "unknown", "robot": "cart", "tour": "[desk]"}


def test_an_unknown_start_puts_locate_before_the_network() -> None:
    task, known = load_task(TASK, UNKNOWN), load_task(TASK, {**UNKNOWN, "start": "home"})
    assert not task.knowledge.is_start_known
    assert len(task.network.actions) == len(known.network.actions) + 1
    plan = Planner(task.network).plan(task.network.start)
    assert not isinstance(plan, NoWay)
    assert [action.do for action in plan.actions] == ["LOCATE", "MOVE_TO"]
    assert plan.actions[0].target == known.network.start


def test_a_network_with_locate_is_taken_as_it_is() -> None:
    task = load_task(DRIVE_MAP / "locate.yaml")
    assert task.network.start == "lost"
    assert [action.do for action in task.network.actions] == ["LOCATE", "MOVE_TO"]


@pytest.mark.parametrize(
    ("robot", "needed"),
    [
        ("atrv", "the localizer scan or odometry, not positioning"),
        ("el_verde", "a base that turns on the spot"),
    ],
)
def test_a_robot_that_cannot_locate_itself_is_refused(robot: str, needed: str) -> None:
    with pytest.raises(FileError) as refused:
        check(TASK, settings={**UNKNOWN, "robot": robot})
    wrong = [str(finding) for finding in refused.value.findings]
    assert any(
        "an unknown start is found by scans on a map; needed: " in item and needed in item for item in wrong
    )


def test_a_run_begins_without_a_pose_only_before_locate() -> None:
    settings = {"start": "unknown", "robot": "cart", "tour": "[desk, store]"}
    with pytest.raises(NotLocated, match=r"from 'next\[2\]' to LOCATE; allowed: pose unknown, or a place"):
        check(TASK, settings=settings, situation="next[2]")
    assert check(TASK, settings=settings, situation="pose unknown").task.network.start == "pose unknown"
    assert check(TASK, settings={**settings, "start": "home"}, situation="next[2]").errors == ()


def test_a_misspelt_unknown_start_is_suggested() -> None:
    with pytest.raises(FileError, match="unknown place 'unknwon'; did you mean 'unknown'"):
        load_task(TASK, {**UNKNOWN, "start": "unknwon"})


def test_a_place_named_unknown_is_a_place(tmp_path: Path) -> None:
    text = (DRIVE_MAP / "places.yaml").read_text(encoding="utf-8")
    (tmp_path / "places.yaml").write_text(text.replace("  home:", "  unknown:"), encoding="utf-8")
    for name in ("map.yaml", "map.png", "task.yaml"):
        (tmp_path / name).write_bytes((DRIVE_MAP / name).read_bytes())
    task = load_task(tmp_path / "task.yaml", UNKNOWN)
    assert task.knowledge.is_start_known
    assert (task.knowledge.start.x, task.knowledge.start.y) == (1.0, 5.2)


def test_a_simulated_robot_is_set_down_anywhere_free() -> None:
    grid = load_map(DRIVE_MAP / "map.yaml")[0]
    poses = [drawn_pose(grid, 0.34, seed) for seed in range(20)]
    assert len({(round(pose.x, 2), round(pose.y, 2)) for pose in poses}) > 15
    for pose in poses:
        row, column = grid.to_cell([[pose.x, pose.y]])[0]  # type: ignore[arg-type]
        assert not grid.blocked[row, column]
    assert drawn_pose(grid, 0.34, 3) == poses[3]


@pytest.mark.slow
def test_a_run_from_an_unknown_start_ends_truly(tmp_path: Path) -> None:
    summary, status = run_task(TASK, tmp_path, RunOptions(settings=UNKNOWN, seed=4))
    assert status == 0
    assert summary["outcome"] == "Success"
    assert summary["actions"] == 2
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["localisation_mm_max"] < 50.0


@pytest.mark.slow
def test_the_robot_begins_without_a_pose() -> None:
    with prepare(TASK, settings=UNKNOWN) as prepared:
        assert not prepared.robot.localization.is_located
