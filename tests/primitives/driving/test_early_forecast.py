"""A long drive whose end the sensors will not determine is refused before it begins."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization import pose_forecast
from handcart.backends.robot.localization.determination import PoseNeed
from handcart.primitives.driving.early_forecast import LONG_DRIVE_M, check_will_be_determined
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap, from_boxes
from handcart.robotics.numerics.stepwise import finish

LENGTH_M = 70.0
START, GOAL = Pose2(2.0, 1.6, 0.0), Pose2(2.0 + LONG_DRIVE_M, 1.6, 0.0)


@pytest.fixture(autouse=True)
def _few_scans(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pose_forecast, "MAX_SCANS", 20)


class StandingRobot(SimpleNamespace):
    """A robot at rest, as far as a forecast asks it."""

    def compute(self, work: Callable[..., Any], *args: object) -> Generator[None, None, Any]:
        self.computed += 1
        return work(*args)
        yield


def corridor(pillars: bool) -> GridMap:
    walls = [FloorBox(0.5 * LENGTH_M, y, 0.0, LENGTH_M, 0.1) for y in (0.1, 3.1)]
    walls += [FloorBox(0.0, 1.6, 0.0, 0.1, 3.1)]
    posts = [FloorBox(x, y, 0.0, 0.3, 0.3) for x in np.arange(2.5, 69.0, 3.0) for y in (0.3, 2.9)]
    return from_boxes(walls + posts * pillars, 0.1, (-0.5, -0.5), (LENGTH_M + 1.0, 4.5))


def checked(grid: GridMap, need: PoseNeed, goal: Pose2 = GOAL) -> StandingRobot:
    where = SimpleNamespace(map_field=None, source="RangeSensor")
    robot = StandingRobot(spec=load_robot("cart"), pose=START, localization=where, computed=0)
    place = Place(x_m=goal.x, y_m=goal.y, heading_deg=0.0)
    route = np.array([START[:2], goal[:2]])
    finish(check_will_be_determined(robot, grid, "far", place, need, route))  # type: ignore[arg-type]
    return robot


def test_long_drive_to_where_nothing_tells_the_pose_is_refused() -> None:
    with pytest.raises(Discrepancy, match=r"not determined: at far, after 50 m, .* along 0 deg") as refused:
        checked(corridor(False), PoseNeed(0.04, math.radians(1.0)))
    assert refused.value.permanent
    assert refused.value.cause is causes.UNDETERMINED


def test_long_drive_along_pillars_is_begun() -> None:
    assert checked(corridor(True), PoseNeed(0.2, math.radians(3.0))).computed == 1


def test_place_that_needs_little_less_than_expected_is_tried() -> None:
    assert checked(corridor(False), PoseNeed(1.5, math.radians(5.0))).computed == 1


def test_short_drive_is_not_forecast() -> None:
    near = Pose2(GOAL.x - 1.0, *GOAL[1:])
    assert checked(corridor(False), PoseNeed(0.04, math.radians(1.0)), near).computed == 0
