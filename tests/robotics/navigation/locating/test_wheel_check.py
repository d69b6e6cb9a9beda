"""Wheels that turn while something holds the base: scans deny them, and show where it is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.locating.moved_scan import rolled_motion
from handcart.robotics.navigation.locating.wheel_check import Contradiction, WheelCheck
from handcart.robotics.navigation.odometry.odometry import OdometryErrors
from handcart.robotics.navigation.scans.start_search import ScanBeams

from ..conftest import ANGLES, Boxes

TREAD_M, PERIOD_S = 0.4, 0.05
TURNS, DRIVES, BACKS, BENDS = (-0.015, 0.015), (0.025, 0.025), (-0.025, -0.025), (0.01, 0.03)


class Drive:
    """A base whose wheels roll alike in each period, among boxes."""

    def __init__(self, boxes: Boxes, pose: Pose2 = Pose2(3.0, 3.5, 0.0)) -> None:
        self.boxes, self.pose, self.by_wheels, self.scans, self.reach = boxes, pose, pose, 0, 30.0
        self.check = WheelCheck(TREAD_M, OdometryErrors(), PERIOD_S)
        self.check.take(self.seen(pose))
        self.check.note_pose(pose)

    def seen(self, pose: Pose2) -> ScanBeams:
        self.scans += 1
        noise = np.random.default_rng(self.scans).normal(0.0, 0.01, len(ANGLES))
        ranges = box_ranges(self.boxes, pose, ANGLES) + noise
        ranges[ranges > self.reach] = np.inf
        return ScanBeams(np.zeros(2), ANGLES, ranges, self.reach)

    def roll(
        self, wheels: tuple[float, float], shares: tuple[float, float], seen_from: Pose2 | None = None
    ) -> Contradiction | None:
        """Roll the wheels for a period; the base gets on by a share of it at each wheel."""
        left, right = wheels
        self.pose = self.pose.compose(rolled_motion(shares[0] * left, shares[1] * right, 0.0, TREAD_M))
        self.by_wheels = self.by_wheels.compose(rolled_motion(left, right, 0.0, TREAD_M))
        self.check.roll(left, right, 0.0)
        found = self.check.take(self.seen(seen_from or self.pose))
        if found is not None:
            self.by_wheels = found.pose
        self.check.note_pose(self.by_wheels)
        return found


@pytest.mark.parametrize("wheels", [TURNS, DRIVES, BACKS, BENDS])
@pytest.mark.parametrize("shares", [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.4, 0.4)])
def test_a_held_base_is_found_where_it_is(
    library_boxes: Boxes, wheels: tuple[float, float], shares: tuple[float, float]
) -> None:
    drive = Drive(library_boxes)
    for _ in range(8):
        assert drive.roll(wheels, (1.0, 1.0)) is None
    found = [drive.roll(wheels, shares) for _ in range(12)]
    first = next(number for number, item in enumerate(found) if item is not None)
    assert (first + 1) * PERIOD_S <= 0.6
    assert drive.check.is_contradicted
    assert drive.by_wheels.distance(drive.pose) < 0.05
    assert drive.by_wheels.turn(drive.pose) < math.radians(4.0)


@pytest.mark.parametrize("wheels", [TURNS, DRIVES, BENDS])
def test_free_wheels_are_not_denied(library_boxes: Boxes, wheels: tuple[float, float]) -> None:
    """A person walks along, and the wheels slip by some percent."""
    drive = Drive(library_boxes)
    for number in range(40):
        person = (3.5 + 0.05 * number, 4.4, 0.0, 0.4, 0.4)
        drive.boxes = [*library_boxes, person]
        assert drive.roll(wheels, (0.97, 0.94)) is None
    assert not drive.check.is_contradicted


def test_scans_that_lag_by_two_periods_deny_no_wheels(library_boxes: Boxes) -> None:
    drive = Drive(library_boxes)
    past = [drive.pose] * 3
    for number in range(30):
        wheels = (-0.02, 0.02) if number < 15 else (0.0, 0.0)
        assert drive.roll(wheels, (1.0, 1.0), past[-2]) is None
        past.append(drive.pose)


def test_wheels_are_believed_again_once_scans_agree(library_boxes: Boxes) -> None:
    drive = Drive(library_boxes)
    for _ in range(12):
        drive.roll(TURNS, (0.0, 0.0))
    assert drive.check.is_contradicted
    for _ in range(12):
        drive.roll(TURNS, (1.0, 1.0))
    assert not drive.check.is_contradicted
    assert not drive.check.is_doubtful


def test_an_old_scan_given_again_denies_no_wheels(library_boxes: Boxes) -> None:
    drive = Drive(library_boxes)
    scan = drive.seen(drive.pose)
    drive.check.take(scan)
    for _ in range(20):
        drive.check.roll(*TURNS, 0.0)
        assert drive.check.take(scan) is None


def test_a_corridor_that_looks_alike_denies_no_wheels() -> None:
    """Scans show no motion along it, whether the base is held or not."""
    walls: Boxes = [(0.0, y, 0.0, 80.0, 0.1) for y in (2.4, 4.6)]
    drive = Drive(walls)
    drive.reach = 12.0
    for _ in range(40):
        assert drive.roll(DRIVES, (1.0, 1.0)) is None
    assert not drive.check.is_contradicted


@pytest.mark.parametrize(
    ("jump", "is_held"),
    [(Pose2(0.0, 0.0, 0.2), True), (Pose2(0.0, 0.0, 0.45), False), (Pose2(-0.5, 0.4, 0.0), False)],
)
def test_jump_farther_than_a_base_slides_is_no_held_base(
    library_boxes: Boxes, jump: Pose2, is_held: bool
) -> None:
    """Between two scans it was lifted and set down near by, or only turned by what it ran into."""
    drive = Drive(library_boxes)
    for _ in range(8):
        drive.roll(DRIVES, (1.0, 1.0))
    drive.pose = drive.pose.compose(jump)
    found = [drive.roll(DRIVES, (1.0, 1.0)) for _ in range(3)]
    assert any(item is not None for item in found) is is_held
