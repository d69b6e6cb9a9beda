"""Commands and trackers of a base that drives in any direction."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.following.pose_regulator import PoseRegulator, PoseTolerance
from handcart.robotics.navigation.following.sideways_tracking import make_regulator, make_tracker

LIMITS = DriveLimits(0.6, 1.5, 0.5, 2.0, sideways=0.3)
DT = 0.05
TOLERANCE = PoseTolerance(0.005, 0.005)


def drive(law: PathTracker | PoseRegulator, pose: Pose2, seconds: float = 60.0) -> list[Pose2]:
    """Return the poses until the law has finished; each command is checked against the limits."""
    poses, last = [pose], np.zeros(2)
    for _ in range(round(seconds / DT)):
        if law.finished(pose):
            return poses
        speed, turn, sideways = law.command(pose, DT)
        assert math.hypot(speed / LIMITS.speed, sideways / LIMITS.sideways) <= 1.0 + 1e-9
        assert abs(turn) <= LIMITS.turn_rate + 1e-9
        cos, sin = math.cos(pose.theta), math.sin(pose.theta)
        now = np.array([cos * speed - sin * sideways, sin * speed + cos * sideways])
        assert np.hypot(*(now - last)) <= 1.3 * LIMITS.acceleration * DT
        halfway = pose.compose(Pose2(0.0, 0.0, 0.5 * turn * DT))
        last, pose = now, halfway.compose(Pose2(speed * DT, sideways * DT, 0.5 * turn * DT))
        poses.append(pose)
    raise AssertionError(f"not there: {pose}")


@pytest.mark.parametrize("goal", [Pose2(0.0, 0.4, 0.0), Pose2(-0.3, -0.2, 0.0), Pose2(0.2, 0.2, 2.5)])
def test_a_pose_beside_is_reached_straight(goal: Pose2) -> None:
    poses = drive(make_regulator(goal, LIMITS, TOLERANCE), Pose2(0.0, 0.0, 0.0))
    assert poses[-1].distance(goal) <= TOLERANCE.position
    assert poses[-1].turn(goal) <= TOLERANCE.heading
    way = np.array([pose[:2] for pose in poses])
    across = np.abs(way @ (-goal.y, goal.x)) / math.hypot(goal.x, goal.y)
    assert across.max() < 0.02
    if goal.theta == 0.0:
        assert max(abs(pose.theta) for pose in poses) < 1e-6


@pytest.mark.parametrize("reverse", [False, True])
def test_a_route_is_followed_and_its_end_turned_to_on_the_way(reverse: bool) -> None:
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])
    poses = drive(make_tracker(points, 0.0, LIMITS, reverse), Pose2(0.0, 0.05, 1.0))
    end = poses[-1]
    assert end.distance(Pose2(2.0, 2.0, 0.0)) < 0.008
    assert abs(end.theta) < 0.005
    middle = next(pose for pose in poses if pose.x > 1.2)
    assert middle.turn(Pose2(0.0, 0.0, math.pi if reverse else 0.0)) < 0.1  # it faces along the route
    assert max(min(abs(pose.y), abs(pose.x - 2.0)) for pose in poses) < 0.12
    slowest = min(a.distance(b) / DT for a, b in pairwise(poses[20:-40]))
    assert slowest > 0.02  # it turns as it drives


def test_a_base_that_cannot_drive_sideways_gets_the_other_law() -> None:
    plain = LIMITS._replace(sideways=0.0)
    assert type(make_tracker(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.0, plain)) is PathTracker
    regulator = make_regulator(Pose2(0.0, 1.0, 0.0), plain, TOLERANCE)
    assert len(regulator.command(Pose2(0.0, 0.0, 0.0), DT)) == 2


def test_held_it_comes_to_rest() -> None:
    tracker = make_tracker(np.array([[0.0, 0.0], [3.0, 0.0]]), 0.0, LIMITS)
    pose, command = Pose2(0.0, 0.0, math.pi / 2), (0.0, 0.0, 0.0)
    for _ in range(10):
        command = tracker.command(pose, DT)  # type: ignore[assignment]
    assert command[2] < -0.04
    for _ in range(30):
        command = tracker.hold(pose, DT)  # type: ignore[assignment]
    assert np.abs(command).max() < 1e-9
