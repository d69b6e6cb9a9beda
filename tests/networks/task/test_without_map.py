"""Tasks with `map: none`: places relative to the start, among what is sensed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.evaluation.judging.survey import SurveyedRun
from handcart.evaluation.trials.running import run_task
from handcart.evaluation.viewing.playback.scenery import scenery_of
from handcart.files.errors import FileError
from handcart.networks.task.preparing import check, prepare
from handcart.networks.task.without_map import MARGIN_M, open_floor
from handcart.robotics.geometry.pose2 import Pose2

TASK = """\
format: handcart-task/1
title: Drive to a pose relative to the start
robot: cart
world: world.yaml
knowledge: {map: none, places: places.yaml}
start: here
goal: there
situations:
  here: {base: at the start}
  there: {base: there}
actions:
  - {do: MOVE_TO, from: here, to: there, cost_s: 30, with: {place: there}}
"""
WORLD = """\
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0, heading_deg: 0}
walls:
  - {from_m: [-3, -3], to_m: [8, -3]}
  - {from_m: [8, -3], to_m: [8, 3]}
  - {from_m: [8, 3], to_m: [-3, 3]}
  - {from_m: [-3, 3], to_m: [-3, -3]}
furniture:
  - {name: table, x_m: 2.5, y_m: 0.1, heading_deg: 20, size_m: [0.8, 1.2, 0.8]}
"""
PLACE = "{x_m: 5.0, y_m: 0.5, heading_deg: 90, tolerance_mm: TOLERANCE, tolerance_deg: 8}"
PLACES = f"format: handcart-places/1\nplaces:\n  there: {PLACE}\n"


def written(folder: Path, tolerance_mm: int, task: str = TASK) -> Path:
    (folder / "world.yaml").write_text(WORLD, encoding="utf-8")
    (folder / "places.yaml").write_text(PLACES.replace("TOLERANCE", str(tolerance_mm)), encoding="utf-8")
    (folder / "task.yaml").write_text(task, encoding="utf-8")
    return folder / "task.yaml"


def test_floor_is_free_around_the_start_and_all_places() -> None:
    grid = open_floor([Pose2(30.0, -4.0, 0.0), Pose2(2.0, 1.0, 0.0)])
    assert not grid.occupied.any()
    assert not grid.unknown.any()
    corners = np.array(
        [[-MARGIN_M + 0.1, -4.0 - MARGIN_M + 0.1], [30.0 + MARGIN_M - 0.1, 1.0 + MARGIN_M - 0.1]]
    )
    assert grid.inside(corners).all()
    assert not grid.inside(corners + np.array([[-0.3, 0.0], [0.3, 0.0]])).any()
    assert open_floor([Pose2(1e4, 1e4, 0.0)]).occupied.size < 5e6


def test_task_without_a_map_is_checked(tmp_path: Path) -> None:
    assert not check(written(tmp_path, 500)).errors


def test_mask_and_unknown_start_need_a_map(tmp_path: Path) -> None:
    task = TASK.replace("map: none,", "map: none, start: unknown,")
    with pytest.raises(FileError, match=r"task.yaml:5:.*found by scans on a map; needed: the key `map`"):
        check(written(tmp_path, 500, task))


def test_its_frame_is_that_of_the_start_wherever_that_is(tmp_path: Path) -> None:
    """Judge and pictures move what the robot knows to where it began."""
    path = written(tmp_path, 500)
    world = (tmp_path / "world.yaml").read_text(encoding="utf-8")
    moved = world.replace("{x_m: 0.0, y_m: 0.0, heading_deg: 0}", "{x_m: 1.0, y_m: -1.5, heading_deg: 90}")
    (tmp_path / "world.yaml").write_text(moved, encoding="utf-8")
    with prepare(path) as prepared:
        run = SurveyedRun.of(prepared)
        assert run.world.base == pytest.approx(Pose2(1.0, -1.5, np.pi / 2))
        assert run.base_on_map == pytest.approx(Pose2(0.0, 0.0, 0.0))
        scenery = scenery_of(prepared, run.world)
        assert scenery.world_t_map == pytest.approx((1.0, -1.5, np.pi / 2))
        for _ in range(20):
            prepared.robot.base.drive(0.3, 0.0)
            prepared.robot.step()
        assert run.base_on_map.x > 0.1
        assert run.base_on_map == pytest.approx(prepared.robot.pose, abs=0.02)


@pytest.mark.slow
def test_it_drives_around_a_table_to_a_pose_relative_to_the_start(tmp_path: Path) -> None:
    summary, code = run_task(written(tmp_path, 500), tmp_path / "runs")
    assert (code, summary["fails"]) == (0, 0)
    assert summary["metrics"]["contacts_of_base"] == 0
    assert summary["metrics"]["untrue"] == []
    assert summary["metrics"]["arrival_mm_max"] < 100.0


@pytest.mark.slow
def test_a_pose_more_exact_than_the_drive_is_no_success(tmp_path: Path) -> None:
    """The error grows with the way: 40 mm cannot be promised 5 m away."""
    summary, code = run_task(written(tmp_path, 40), tmp_path / "runs")
    assert code == 3
    assert "not determined" in summary["reason"]
    assert summary["metrics"]["untrue"] == []
