"""What `handcart check` expects of the pose at places, by map and lidar alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.determination import PoseNeed
from handcart.backends.robot.localization.pose_forecast import PoseForecast, forecast_pose
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import FloorBox, from_boxes
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

NEED = PoseNeed(0.04, math.radians(1.0))
HALL_NEED = PoseNeed(0.05, math.radians(1.0))  # a corner leaves half a cell open in both axes
WALLS = [FloorBox(20.0, y, 0.0, 40.0, 0.1) for y in (0.1, 3.1)] + [
    FloorBox(x, 1.6, 0.0, 0.1, 3.1) for x in (0.0, 40.0)
]
PILLARS = [FloorBox(x, y, 0.0, 0.3, 0.3) for x in np.arange(2.0, 39.0, 3.0) for y in (0.3, 2.9)]


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
    found = forecast(False, reach)
    assert found.found is not None
    assert found.found.direction == pytest.approx(0.0, abs=0.02)
    assert found.found.size > 0.1
    assert found.blind_m == pytest.approx(20.0 - reach, abs=3.0)


def test_what_the_lidar_sees_is_nothing_to_tell() -> None:
    assert forecast(True, 5.0).found is None
    assert forecast(False, 25.0).found is None


def test_a_place_that_needs_less_is_nothing_to_tell() -> None:
    assert forecast(False, 10.0, PoseNeed(2.0, math.radians(5.0))).found is None


@pytest.mark.parametrize(("along", "across", "is_reported"), [(2.0, 0.05, False), (0.05, 2.0, True)])
def test_a_forecast_counts_in_the_direction_of_the_need(
    along: float, across: float, is_reported: bool
) -> None:
    found = forecast(False, 10.0, PoseNeed(along, math.radians(5.0), across)).found
    assert (found is not None) is is_reported


def hall_forecast(reach: float) -> PoseForecast:
    """Across an empty hall of 14 m, from crates in one corner to crates in the opposite one."""
    walls = [FloorBox(7.0, y, 0.0, 14.0, 0.1) for y in (0.0, 14.0)] + [
        FloorBox(x, 7.0, 0.0, 0.1, 14.0) for x in (0, 14)
    ]
    crates = [FloorBox(x, y, 0.0, 0.6, 0.6) for x, y in ((1.0, 3.5), (3.2, 1.0), (13.0, 11.0), (10.5, 13.0))]
    robot = load_robot("cart")
    assert robot.range_sensor is not None
    lidar = robot.range_sensor.model_copy(update={"reach_m": reach})
    field = LikelihoodField(from_boxes(walls + crates, 0.05, (-0.5, -0.5), (15.0, 15.0)))
    route = np.array([[2.2, 2.2], [11.8, 11.8]])
    return forecast_pose(field, robot, lidar, Pose2(2.2, 2.2, math.pi / 4), route, HALL_NEED)


@pytest.mark.parametrize("reach", [4.0, 5.0])
def test_silent_route_to_a_well_seen_place_is_found(reach: float) -> None:
    found = hall_forecast(reach)
    assert found.found is None  # both corners are seen well: the pose at the place is determined
    assert found.silent_at is not None
    middle = math.hypot(found.silent_at.x - 7.0, found.silent_at.y - 7.0)
    assert middle < math.hypot(7.0 - 2.2, 7.0 - 2.2) - 0.5
    assert found.silent_at.x < 6.0  # where the silence begins
    assert 1.0 < found.silent_m < found.route_m
    assert 0.005 < found.silent_sigma_m < 0.3


def test_route_with_echoes_everywhere_is_no_finding() -> None:
    found = hall_forecast(12.0)
    assert (found.silent_m, found.silent_at) == (0.0, None)


@pytest.mark.parametrize(
    ("cell", "docks", "is_reported"), [(0.02, False, False), (0.1, False, True), (0.1, True, False)]
)
def test_walls_on_one_side_leave_half_a_cell_open(cell: float, docks: bool, is_reported: bool) -> None:
    corner = [FloorBox(5.0, 0.0, 0.0, 10.0, 0.2), FloorBox(0.0, 5.0, 0.0, 0.2, 10.0)]
    robot = load_robot("cart")
    assert robot.range_sensor is not None
    field = LikelihoodField(from_boxes(corner, cell, (-0.5, -0.5), (11.0, 11.0)))
    start, route = Pose2(2.0, 2.0, 0.0), np.array([[2.0, 2.0], [4.0, 4.0]])
    found = forecast_pose(field, robot, robot.range_sensor, start, route, NEED, docks)
    assert (found.found is not None) is is_reported
