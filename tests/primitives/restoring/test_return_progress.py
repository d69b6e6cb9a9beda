"""A drive back that does not get on ends with its cause, and not only with the time for restoring."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.restoring.car_retrace import _drive_back as drive_car_back
from handcart.primitives.restoring.car_retrace import _straight_to
from handcart.primitives.restoring.retrace import _drive_back
from handcart.primitives.restoring.return_progress import HELD_RETURN_S, STUCK_RETURN_S, ReturnProgress
from handcart.primitives.restoring.trace import Moment
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits

PERIOD = 0.05
ENDLESS_S = 2.0 * HELD_RETURN_S
STRETCH = [Moment(Pose2(0.02 * k, 0.0, 0.0), np.empty(0), 0.0, Pose2(0.02 * k, 0.0, 0.0)) for k in range(51)]


class HinderedRobot:
    """Base on a straight line that drives as commanded down to where it is stopped, without noise."""

    def __init__(self, stops_at: float, spec: str = "atrv") -> None:
        """Stop the base at `stops_at` on its way from 1 m back to 0, in [m]."""
        self.period, self.time, self.held, self.share_for_people = PERIOD, 0.0, None, 1.0
        self.drive_limits, self.spec, self.joint_speeds = DriveLimits(), load_robot(spec), np.empty(0)
        self.base, self.localization, self.backend = self, self, SimpleNamespace(get=lambda _: None)
        self.displacement = None
        self.pose, self._stops_at = Pose2(1.0, 0.0, 0.0), stops_at

    @property
    def odometry_pose(self) -> Pose2:
        """Return the pose, which never jumps."""
        return self.pose

    def drive(self, speed: float, turn_rate: float) -> None:
        del turn_rate
        self.pose = Pose2(max(self._stops_at, self.pose.x + speed * PERIOD), 0.0, 0.0)
        self.time += PERIOD
        assert self.time < ENDLESS_S, "the drive back has no end"


def drive(robot: Any) -> None:
    for _ in _drive_back(robot, STRETCH, None):
        pass


def drive_car(robot: Any) -> None:
    for _ in drive_car_back(robot, STRETCH, False):
        pass


def drive_car_straight(robot: Any) -> None:
    start: Any = SimpleNamespace(pose=Pose2(0.0, 0.0, 0.0))
    for _ in _straight_to(robot, start):
        pass


@pytest.mark.parametrize("stops_at", [0.5, 0.1])
def test_base_stuck_on_its_way_back_is_reported(stops_at: float) -> None:
    robot = HinderedRobot(stops_at)
    with pytest.raises(Discrepancy, match="doesn't get on on its way back") as stuck:
        drive(robot)
    assert stuck.value.cause is causes.NO_PROGRESS
    assert STUCK_RETURN_S < robot.time < STUCK_RETURN_S + 10.0


@pytest.mark.parametrize("drives", [drive_car, drive_car_straight])
def test_car_stuck_on_its_way_back_is_reported(drives: Any) -> None:
    robot = HinderedRobot(0.5, "el_verde")
    with pytest.raises(Discrepancy, match="doesn't get on on its way back"):
        drives(robot)
    assert robot.time < STUCK_RETURN_S + 20.0


def test_base_that_gets_on_has_all_the_time_it_needs() -> None:
    robot: Any = HinderedRobot(0.0)
    progress = ReturnProgress(robot)
    for k in range(math.ceil(5.0 * HELD_RETURN_S / PERIOD)):
        progress.check(1e-3 * k)


@pytest.mark.parametrize("by", ["obstacle", "person"])
def test_held_base_has_longer_than_a_stuck_one(by: str) -> None:
    """What held the base may leave after a long time, and the base then drives on."""
    robot: Any = HinderedRobot(0.0)
    progress = ReturnProgress(robot)
    robot.held = SimpleNamespace(words="the scan shows something") if by == "obstacle" else None
    robot.share_for_people = 0.0 if by == "person" else 1.0
    for _ in range(math.ceil(0.9 * HELD_RETURN_S / PERIOD)):
        progress.check(0.0)
    robot.held, robot.share_for_people = None, 1.0
    for _ in range(math.ceil(0.5 * STUCK_RETURN_S / PERIOD)):
        progress.check(0.0)
    progress.check(0.1)
    robot.held = SimpleNamespace(words="the scan shows something")
    with pytest.raises(Discrepancy, match="the scan shows something"):
        for _ in range(math.ceil(1.1 * HELD_RETURN_S / PERIOD)):
            progress.check(0.1)
