"""Scans that change at once while the wheels say otherwise: the base was lifted."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.locating.scan_jump import CONFIRMED_CHANGES, ScanJump
from handcart.robotics.navigation.scans.start_search import ScanBeams

from ..conftest import ANGLES, Boxes

TREAD_M = 0.4
STEP_M = 0.05


def seen(boxes: Boxes, pose: Pose2, seed: int) -> ScanBeams:
    noise = np.random.default_rng(seed).normal(0.0, 0.01, len(ANGLES))
    return ScanBeams(np.zeros(2), ANGLES, box_ranges(boxes, pose, ANGLES) + noise, 30.0)


def test_a_lifted_base_is_noticed_after_few_scans(library_boxes: Boxes) -> None:
    jump, pose = ScanJump(), Pose2(3.0, 3.5, 0.0)
    for number in range(10):
        assert not jump.take(seen(library_boxes, pose, number), at_rest=False, pose=pose)
        jump.roll(STEP_M, STEP_M, TREAD_M)
        pose = pose.compose(Pose2(STEP_M, 0.0, 0.0))
    elsewhere = Pose2(10.5, 7.0, 2.0)
    found = [jump.take(seen(library_boxes, elsewhere, 20 + k), at_rest=False, pose=pose) for k in range(8)]
    assert found.index(True) == CONFIRMED_CHANGES - 1


def test_a_drive_past_things_that_appear_is_no_lifting(library_boxes: Boxes) -> None:
    jump, pose = ScanJump(), Pose2(3.0, 3.5, 0.0)
    for number in range(40):
        person = [(pose.x + 0.9, pose.y + 0.3, 0.0, 0.5, 0.4)] if number > 15 else []
        assert not jump.take(seen([*library_boxes, *person], pose, number), at_rest=False, pose=pose)
        jump.roll(0.5 * STEP_M, STEP_M, TREAD_M)
        turn = 0.5 * STEP_M / TREAD_M
        pose = pose.compose(Pose2(0.75 * STEP_M, 0.0, turn))


def test_one_wrong_scan_is_no_lifting(library_boxes: Boxes) -> None:
    jump, pose = ScanJump(), Pose2(3.0, 3.5, 0.0)
    for number in range(12):
        where = Pose2(10.5, 7.0, 2.0) if number == 5 else pose
        assert not jump.take(seen(library_boxes, where, number), at_rest=False, pose=pose)


def test_an_old_scan_given_again_is_no_lifting(library_boxes: Boxes) -> None:
    """The wheels continue; the next new scan fits their pose."""
    jump, pose = ScanJump(), Pose2(3.0, 3.5, 0.0)
    old = seen(library_boxes, pose, 0)
    for _ in range(15):
        assert not jump.take(old, at_rest=False, pose=pose)
        jump.roll(STEP_M, STEP_M, TREAD_M)
        pose = pose.compose(Pose2(STEP_M, 0.0, 0.0))
    assert not jump.take(seen(library_boxes, pose, 1), at_rest=False, pose=pose)
    assert jump.share < 0.3


def test_an_old_scan_with_blind_beams_is_no_lifting(library_boxes: Boxes) -> None:
    """Given again while the wheels drive on, as long as a lifted base needs to be noticed."""
    jump, pose = ScanJump(), Pose2(3.0, 3.5, 0.0)
    old = seen(library_boxes, pose, 0)
    old.ranges[40:60] = np.nan
    for _ in range(40):
        assert not jump.take(old, at_rest=False, pose=pose)
        jump.roll(-0.5 * STEP_M, 0.5 * STEP_M, TREAD_M)
    assert jump.share == 0.0


def test_scans_of_a_sensor_off_the_middle_fit_while_it_turns(library_boxes: Boxes) -> None:
    jump, pose, origin = ScanJump(), Pose2(3.0, 3.5, 0.0), np.array([0.3, 0.1])
    for number in range(40):
        at = pose.compose(Pose2(float(origin[0]), float(origin[1]), 0.0))
        assert not jump.take(
            seen(library_boxes, at, number)._replace(origin=origin), at_rest=False, pose=pose
        )
        assert jump.share < 0.1
        jump.roll(-0.5 * STEP_M, 0.5 * STEP_M, TREAD_M)
        pose = pose.compose(Pose2(0.0, 0.0, STEP_M / TREAD_M))


def test_lidar_of_one_beam_shows_no_lift_and_ends_without_error() -> None:
    jump = ScanJump()
    for reach in (1.0, 2.0, 2.0, 0.5):
        assert not jump.take(
            ScanBeams(np.zeros(2), np.zeros(1), np.array([reach]), 4.0), False, Pose2(0.0, 0.0, 0.0)
        )


@pytest.mark.parametrize(
    ("is_followed", "slides", "lifted"), [(True, True, False), (False, True, True), (True, False, True)]
)
def test_base_that_slides_with_standing_wheels_is_followed(
    library_boxes: Boxes, is_followed: bool, slides: bool, lifted: bool
) -> None:
    """It slides off an edge that it ran onto, and turns; the estimate follows the scans, or does not.

    Without a contact before, an estimate that follows may be one that was misled.
    """
    jump, pose = ScanJump(), Pose2(3.0, 3.5, 0.0)
    found = []
    for number in range(20):
        estimate = pose if is_followed else Pose2(3.0, 3.5, 0.0)
        found.append(jump.take(seen(library_boxes, pose, number), at_rest=True, pose=estimate, slides=slides))
        pose = pose.compose(Pose2(0.0, 0.05, 0.3)) if 5 <= number < 8 else pose
    assert any(found) is lifted
