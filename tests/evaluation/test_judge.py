"""The judge must be able to find a lie."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from backends.robot_file import load_robot
from evaluation.judge import broken_promises, truth_of
from evaluation.shelving import longest_rising, shelving
from robotics.geometry.pose2 import Pose2
from robotics.perception.call_number import parse


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


def test_the_longest_rising_row_leaves_the_misplaced_book_out() -> None:
    calls = ["100 AAA", "200 AAA", "150.5 BBB", "150.15 BBB", "300 AAA", "120 CCC", "400 AAA"]
    numbers = [number for call in calls if (number := parse(call))]
    rising = longest_rising(numbers)
    assert [calls[i] for i in rising] == ["100 AAA", "150.15 BBB", "300 AAA", "400 AAA"]
