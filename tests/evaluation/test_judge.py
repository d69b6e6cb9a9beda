"""The judge must be able to find a lie."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from backends.robot_file import load_robot
from evaluation.judge import Judge, broken_promises, truth_of
from evaluation.shelving import longest_rising, shelving
from networks.run import prepare
from networks.run_end import RunEnd
from networks.telemetry import Telemetry
from robotics.geometry.pose2 import Pose2
from robotics.perception.call_number import parse

LIBRARY = Path(__file__).resolve().parents[2] / "tasks" / "return_book"
TOUR = """\
format: handcart-task/1
title: Drive to a shelf
robot: librarian
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: at_home
goal: at_shelf
situations: {at_home: {base: home}, at_shelf: {base: shelf}}
actions:
  - {do: MOVE_TO, from: at_home, to: at_shelf, cost_s: 30, with: {place: shelf_3}}
"""


def test_a_fail_that_did_not_restore_is_found(set_stage: Callable[..., Any]) -> None:
    scene, robot = set_stage().backend.scene, load_robot("librarian")
    before = truth_of(scene)
    assert broken_promises(before, truth_of(scene), robot) == []
    scene.base = Pose2(scene.base.x + 0.1, scene.base.y, scene.base.theta)
    assert any("base_mm" in each for each in broken_promises(before, truth_of(scene), robot))
    scene.base = before.base
    scene.joints = scene.joints + np.array([0.0, 0.02, 0.0, 0.0, 0.0, 0.0])
    assert any("joints_deg" in each for each in broken_promises(before, truth_of(scene), robot))
    scene.joints = before.joints
    book = scene.books[next(iter(scene.books))]
    book.pose = book.pose.copy()
    book.pose[2, 3] -= 0.5
    assert any("book" in each for each in broken_promises(before, truth_of(scene), robot))


def test_a_book_on_the_tray_is_not_in_its_slot(set_stage: Callable[..., Any]) -> None:
    scene = set_stage().backend.scene
    judged = shelving(scene, (scene.tray_book().accession,)).judge(scene)
    assert not judged.slot_correct
    assert not judged.right


def test_a_task_that_only_drives_returns_no_book(tmp_path: Path) -> None:
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (tmp_path / name).write_bytes((LIBRARY / name).read_bytes())
    (tmp_path / "tour.yaml").write_text(TOUR, encoding="utf-8")
    with prepare(tmp_path / "tour.yaml") as prepared:
        judge = Judge(prepared)
        end = RunEnd("Success", "at_shelf", "", 1, 0, 0, ())
        assert judge.metrics(prepared, end, Telemetry())["untrue"] == []


def test_the_longest_rising_row_leaves_the_misplaced_book_out() -> None:
    calls = ["100 AAA", "200 AAA", "150.5 BBB", "150.15 BBB", "300 AAA", "120 CCC", "400 AAA"]
    numbers = [number for call in calls if (number := parse(call))]
    rising = longest_rising(numbers)
    assert [calls[i] for i in rising] == ["100 AAA", "150.15 BBB", "300 AAA", "400 AAA"]
