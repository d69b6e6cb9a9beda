"""A base that does not get on, and a pose that scans correct by more than the base moves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import DriveCommand, WheelTravel
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.progress_watch import ProgressWatch
from handcart.robotics.geometry.pose2 import Pose2

PERIOD_S, SPEED_M_S = 0.05, 0.5
STEP_M = SPEED_M_S * PERIOD_S


def is_blocked(before_m: float, after_m: float, jump_m: float, moved_m: float) -> bool:
    """Drive ahead with a position of these sigmas before and after a correction backwards."""
    held = SimpleNamespace(compares_scans=True)
    where: Any = SimpleNamespace(
        held_base=held,
        odometry_pose=Pose2(0.0, 0.0, 0.0),
        travel=WheelTravel(0.0, 0.0),
        covariance=np.diag([before_m, 0.0, 0.0]) ** 2,
    )
    watch = ProgressWatch(load_robot("cart"), PERIOD_S, where)
    blocked = False
    for number in range(40):
        before, rolled = where.odometry_pose, where.travel
        where.travel = WheelTravel(rolled.left + STEP_M, rolled.right + STEP_M)
        where.odometry_pose = before.compose(Pose2(moved_m, 0.0, 0.0))
        if number == 20:
            where.odometry_pose = before.compose(Pose2(-jump_m, 0.0, 0.0))
            where.covariance = np.diag([after_m, 0.0, 0.0]) ** 2
        watch.update(DriveCommand(SPEED_M_S, 0.0), rolled, before)
        blocked = blocked or watch.blocked is not None or watch.blocked_wheel is not None
    return blocked


@pytest.mark.parametrize(("before_m", "is_found"), [(0.5, False), (0.01, True)])
def test_correction_of_an_unsure_pose_is_no_standstill(before_m: float, is_found: bool) -> None:
    assert is_blocked(before_m, 0.01, jump_m=0.6, moved_m=STEP_M) is is_found


def test_base_that_does_not_move_is_blocked() -> None:
    assert is_blocked(0.01, 0.01, jump_m=0.0, moved_m=0.0)
