"""A skid-steer base, which shifts as it turns, is brought back within its time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.restoring.retrace import RETURN_TOLERANCE, reach_pose
from handcart.primitives.restoring.return_progress import HELD_RETURN_S, STUCK_RETURN_S
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits


class ShiftingRobot:
    """Drives as commanded; turning moves its origin about a point next to it, and a little ahead for good."""

    held: str | None = None
    share_for_people = 1.0
    drive_limits = DriveLimits()
    period = 0.05

    def __init__(self, start: Pose2, beside: float, slides: float, noise: float = 0.0) -> None:
        """Turn about a point `beside` [m] ahead, sliding `slides` [m] per radian; add noise in [m] to
        poses.
        """
        self.true, self.time, self.spec = start, 0.0, load_robot("atrv")
        self.base, self._beside, self._slides = self, beside, slides
        self._noise, self._rng = noise, np.random.default_rng(1)

    @property
    def pose(self) -> Pose2:
        """Return the measured pose."""
        x, y, turn = self._noise * self._rng.standard_normal(3)
        return self.true.compose(Pose2(x, y, 0.25 * turn))

    def drive(self, speed: float, turn_rate: float) -> None:
        turn = turn_rate * self.period
        ahead = speed * self.period + self._slides * abs(turn)
        about = Pose2(self._beside, 0.0, 0.0)
        moved = about.compose(Pose2(ahead, 0.0, turn)).compose(Pose2(-self._beside, 0.0, 0.0))
        self.true, self.time = self.true.compose(moved), self.time + self.period


def bring(robot: Any, goal: Pose2) -> None:
    """Let it reach the goal."""
    for _ in reach_pose(robot, goal, RETURN_TOLERANCE):
        pass


@pytest.mark.parametrize("start", [(0.03, 0.03, 0.4), (-0.02, 0.05, -0.2), (0.0, -0.018, 0.0)])
def test_base_that_turns_about_another_point_is_brought_back_exactly(
    start: tuple[float, float, float],
) -> None:
    robot = ShiftingRobot(Pose2(*start), beside=0.06, slides=0.0)
    bring(robot, Pose2(0.0, 0.0, 0.0))
    assert robot.time < STUCK_RETURN_S / 3
    assert robot.true.distance(Pose2(0.0, 0.0, 0.0)) <= RETURN_TOLERANCE.position


def test_base_sliding_in_a_turn_is_restored_within_tolerance() -> None:
    robot = ShiftingRobot(Pose2(0.03, 0.03, 0.4), beside=0.06, slides=0.03, noise=0.002)
    bring(robot, Pose2(0.0, 0.0, 0.0))
    assert robot.time < STUCK_RETURN_S / 2  # 38 s, were the tolerance not to widen
    assert robot.true.distance(Pose2(0.0, 0.0, 0.0)) <= 0.5e-3 * robot.spec.tolerance.base_mm
    assert robot.true.turn(Pose2(0.0, 0.0, 0.0)) <= 0.5 * math.radians(robot.spec.tolerance.base_deg)


def test_base_that_does_not_come_back_is_reported() -> None:
    robot = ShiftingRobot(Pose2(0.3, 0.0, 0.0), beside=0.0, slides=0.0)
    robot.drive = lambda speed, turn_rate: setattr(robot, "time", robot.time + 0.05)  # type: ignore[method-assign]
    with pytest.raises(Discrepancy, match="doesn't reach its pose"):
        bring(robot, Pose2(0.0, 0.0, 0.0))


def test_a_long_pause_neither_ends_a_return_nor_widens_its_tolerance() -> None:
    robot: Any = ShiftingRobot(Pose2(0.03, 0.0, 0.0), beside=0.0, slides=0.0)
    returning = reach_pose(robot, Pose2(0.0, 0.0, 0.0), RETURN_TOLERANCE)
    next(returning)
    robot.time += 10.0 * STUCK_RETURN_S
    for _ in returning:
        pass
    assert robot.true.distance(Pose2(0.0, 0.0, 0.0)) <= RETURN_TOLERANCE.position


def test_a_person_may_hold_the_base_for_longer_on_its_way_back() -> None:
    robot: Any = ShiftingRobot(Pose2(0.03, 0.0, 0.0), beside=0.0, slides=0.0)
    returning = reach_pose(robot, Pose2(0.0, 0.0, 0.0), RETURN_TOLERANCE, HELD_RETURN_S)
    robot.share_for_people, drives = 0.0, robot.drive
    robot.drive = lambda speed, turn_rate: setattr(robot, "time", robot.time + 0.05)
    while robot.time < 5.0 * STUCK_RETURN_S:
        next(returning)
    robot.share_for_people, robot.drive = 1.0, drives
    for _ in returning:
        pass
    assert robot.true.distance(Pose2(0.0, 0.0, 0.0)) <= RETURN_TOLERANCE.position
