"""A car's way over open ground, planned and driven."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.car_tracker import CarTracker
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.maps.point_discs import point_discs
from handcart.robotics.navigation.routes.car_route import plan_car_route

START, GOAL = Pose2(0.0, 0.0, 0.0), Pose2(10.0, 5.0, 0.5)
SHARPEST = 0.5
LIMITS = DriveLimits(0.5, 0.35, 0.3, 1.0)
DT = 0.025


def driven(tracker: CarTracker, start: Pose2) -> list[Pose2]:
    """Poses of an ideal car."""
    pose, poses = start, [start]
    for _ in range(8000):
        if tracker.finished(pose):
            return poses
        speed, turn = tracker.command(pose, DT)
        assert abs(turn) <= SHARPEST * abs(speed) + 1e-9
        way, angle = speed * DT, turn * DT
        pose = pose.compose(Pose2(way * math.cos(angle / 2), way * math.sin(angle / 2), angle))
        poses.append(pose)
    raise AssertionError("it doesn't come to the end")


@pytest.mark.parametrize("goal", [GOAL, Pose2(3.0, 4.0, math.pi), Pose2(-6.0, 0.5, 0.0)])
def test_it_comes_to_stand_at_the_goal(goal: Pose2) -> None:
    path = plan_car_route(START, goal, np.empty((0, 3)), 1.0, 1.05 / SHARPEST)
    assert path is not None
    end = driven(CarTracker.along(path, START, goal, SHARPEST, LIMITS), START)[-1]
    assert end.distance(goal) < 0.06
    assert end.turn(goal) < 0.1


def test_it_keeps_away_from_what_stands_there() -> None:
    rng = np.random.default_rng(3)
    discs = np.column_stack(
        [rng.uniform(3.0, 27.0, 12), rng.uniform(-6.0, 6.0, 12), rng.uniform(0.3, 1.0, 12)]
    )
    goal = Pose2(34.0, 0.0, 0.0)
    path = plan_car_route(START, goal, discs, 0.8, 1.05 / SHARPEST)
    assert path is not None
    for pose in driven(CarTracker.along(path, START, goal, SHARPEST, LIMITS), START):
        assert (np.hypot(*(discs[:, :2] - pose[:2]).T) - discs[:, 2]).min() > 0.7


@pytest.mark.slow
def test_where_no_way_leads_there_is_none() -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)
    ring = np.column_stack([20.0 + 2.0 * np.cos(angle), 2.0 * np.sin(angle), np.full(8, 0.5)])
    assert plan_car_route(START, Pose2(20.0, 0.0, 0.0), ring, 0.8, 2.1) is None


def test_points_of_two_things_make_two_discs() -> None:
    rng = np.random.default_rng(1)
    things = [rng.uniform(-0.4, 0.4, (40, 2)) + middle for middle in ((3.0, 0.0), (6.0, 2.0))]
    discs = point_discs(np.vstack(things))
    assert len(discs) == 2
    for points in things:
        inside = np.hypot(*np.moveaxis(points[:, None] - discs[None, :, :2], -1, 0)) <= discs[:, 2]
        assert inside.any(axis=1).all()
    assert point_discs(np.empty((0, 2))).shape == (0, 3)
