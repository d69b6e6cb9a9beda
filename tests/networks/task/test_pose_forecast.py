"""What `handcart check` expects of the pose at places, by map and lidar alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.description.robot_loading import load_robot
from handcart.backends.robot.localization.determination import PoseNeed
from handcart.networks.task.pose_forecast import PoseForecast, forecast_pose
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.scan_matching import LikelihoodField
from handcart.robotics.navigation.maps.grid_map import Box, from_boxes

NEED = PoseNeed(0.04, math.radians(1.0))
WALLS = [Box(20.0, y, 0.0, 40.0, 0.1) for y in (0.1, 3.1)] + [Box(x, 1.6, 0.0, 0.1, 3.1) for x in (0.0, 40.0)]
PILLARS = [Box(x, y, 0.0, 0.3, 0.3) for x in np.arange(2.0, 39.0, 3.0) for y in (0.3, 2.9)]


def forecast(pillars: bool, reach: float, need: PoseNeed = NEED) -> PoseForecast:
    """At the middle of a corridor of 40 m, driven to from 3 m."""
    robot = load_robot("cart")
    assert robot.range_sensor is not None
    lidar = robot.range_sensor.model_copy(update={"reach_m": reach})
    field = LikelihoodField(from_boxes(WALLS + PILLARS * pillars, 0.05, (-0.5, -0.5), (41.0, 4.5)))
    route = np.array([[3.0, 1.6], [20.0, 1.6]])
    return forecast_pose(field, robot, lidar, Pose2(3.0, 1.6, 0.0), route, need)


@pytest.mark.parametrize("reach", [5.0, 10.0])
def test_a_corridor_beyond_the_lidars_reach_is_told(reach: float) -> None:
    told = forecast(False, reach)
    assert told.found is not None
    assert told.found.direction == pytest.approx(0.0, abs=0.02)
    assert told.found.size > 0.1
    assert told.blind_m == pytest.approx(20.0 - reach, abs=3.0)


def test_what_the_lidar_sees_is_nothing_to_tell() -> None:
    assert forecast(True, 5.0).found is None
    assert forecast(False, 25.0).found is None


def test_a_place_that_needs_less_is_nothing_to_tell() -> None:
    assert forecast(False, 10.0, PoseNeed(2.0, math.radians(5.0))).found is None


@pytest.mark.parametrize(("along", "across", "told"), [(2.0, 0.05, False), (0.05, 2.0, True)])
def test_a_forecast_counts_in_the_direction_of_the_need(along: float, across: float, told: bool) -> None:
    found = forecast(False, 10.0, PoseNeed(along, math.radians(5.0), across)).found
    assert (found is not None) is told
