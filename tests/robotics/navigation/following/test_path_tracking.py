from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.following.pose_regulator import PoseRegulator, PoseTolerance
from handcart.robotics.numerics.arrays import FloatArray

DT = 0.05


def moved(pose: Pose2, speed: float, turn_rate: float) -> Pose2:
    """Exact arc of one period."""
    turn = turn_rate * DT
    chord = speed * DT * (math.sin(turn / 2) / (turn / 2) if abs(turn) > 1e-9 else 1.0)
    return pose.compose(Pose2(chord * math.cos(turn / 2), chord * math.sin(turn / 2), turn))


def run(
    law: Any, pose: Pose2, seconds: float = 120.0, rng: np.random.Generator | None = None, noise: float = 0.0
) -> tuple[list[Pose2], FloatArray]:
    """Drive until finished; returns all poses and commands."""
    poses, commands = [pose], list[tuple[float, float]]()
    seen = pose
    while not law.finished(seen):
        assert len(commands) < seconds / DT, f"still at {pose} after {seconds} s"
        commands.append(law.command(seen, DT))
        pose = moved(pose, *commands[-1])
        seen = pose if rng is None else Pose2(*(np.array(pose) + rng.normal(0, noise, 3)))
        poses.append(pose)
    return poses, np.array(commands)


def curve(length: float = 6.0) -> np.ndarray:
    x = np.linspace(0.0, length, 120)
    return np.column_stack([x, 0.6 * np.sin(1.2 * x)])


def away_from(points: np.ndarray, poses: list[Pose2]) -> float:
    """Farthest that any pose is from the route, in [m]."""
    dense = np.column_stack(
        [np.interp(np.linspace(0, len(points) - 1, 4000), range(len(points)), points[:, i]) for i in (0, 1)]
    )
    return max(float(np.hypot(*(dense - pose[:2]).T).min()) for pose in poses)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("heading", [None, -2.0])
def test_follows_a_curve_to_its_end(reverse: bool, heading: float | None) -> None:
    points = curve()
    poses, commands = run(PathTracker(points, heading, reverse=reverse), Pose2(0.0, 0.0, 2.5))
    assert math.hypot(poses[-1].x - points[-1, 0], poses[-1].y - points[-1, 1]) < 0.01
    assert heading is None or abs(poses[-1].theta - heading) < 0.01
    assert away_from(points, poses) < 0.03
    driven = commands[np.abs(commands[:, 0]) > 0.1, 0]
    assert np.all(driven < 0) if reverse else np.all(driven > 0)


@pytest.mark.parametrize("reverse", [False, True])
def test_stays_within_limits(reverse: bool) -> None:
    limits = DriveLimits(0.4, 0.9, 0.5, 2.0)
    square = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [0, 0.5]], dtype=float)
    _, commands = run(PathTracker(square, 0.0, limits, reverse), Pose2(0.1, -0.1, 1.0))
    assert np.all(np.abs(commands) <= np.array(limits[:2]) + 1e-9)
    assert np.all(np.abs(np.diff(commands, axis=0, prepend=0.0)) <= np.array(limits[2:4]) * DT + 1e-9)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(
    st.tuples(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25), st.floats(-math.pi, math.pi)),
    st.floats(-math.pi, math.pi),
    st.booleans(),
)
def test_converges_from_any_start_beside_the_route(
    start: tuple[float, float, float], heading: float, reverse: bool
) -> None:
    points = np.array([[0.0, 0.0], [1.5, 0.0], [2.0, 1.0]])
    tracker = PathTracker(points, heading, reverse=reverse)
    poses, _ = run(tracker, Pose2(*start), seconds=60.0)
    goal = Pose2(2.0, 1.0, heading)
    assert poses[-1].distance(goal) <= 0.01
    assert poses[-1].turn(goal) <= 0.01


def test_progress_never_goes_back_and_the_rest_is_what_lies_ahead() -> None:
    tracker = PathTracker(curve(), None)
    pose, before = Pose2(0.0, 0.0, 0.6), 0.0
    for _ in range(100):
        pose = moved(pose, *tracker.command(pose, DT))
        assert tracker.progress >= before
        before = tracker.progress
    assert np.hypot(*np.diff(tracker.ahead, axis=0).T).sum() == pytest.approx(tracker.remaining)


def test_a_route_of_one_point_only_turns() -> None:
    poses, commands = run(PathTracker(np.array([[1.0, 2.0]]), 1.0), Pose2(1.0, 2.0, 0.0))
    assert np.all(commands[:, 0] == 0.0)
    assert abs(poses[-1].theta - 1.0) < 0.01


def test_arrives_with_a_noisy_estimate() -> None:
    rng = np.random.default_rng(0)
    poses, _ = run(PathTracker(curve(), 0.0), Pose2(0.0, 0.0, 0.6), rng=rng, noise=0.002)
    assert poses[-1].distance(Pose2(6.0, float(curve()[-1, 1]), 0.0)) < 0.015


@settings(max_examples=100, deadline=None)
@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_regulator_reaches_any_pose_near_by(x: float, y: float, theta: float, goal_heading: float) -> None:
    goal = Pose2(1.0, -1.0, goal_heading)
    poses, _ = run(PoseRegulator(goal), Pose2(1.0 + x, -1.0 + y, theta), seconds=40.0)
    assert poses[-1].distance(goal) <= 0.008
    assert poses[-1].turn(goal) <= 0.005


def test_regulator_mends_a_sideways_error_in_front_of_a_shelf() -> None:
    tolerance = PoseTolerance(0.004, 0.003)
    poses, _ = run(PoseRegulator(Pose2(0, 0, 0), tolerance=tolerance), Pose2(0.0, 0.03, 0.0), seconds=20.0)
    assert abs(poses[-1].y) <= 0.004
    assert abs(poses[-1].theta) <= 0.003
    assert max(abs(pose.x) for pose in poses) < 0.01


def test_regulator_does_not_stall_at_the_edge_of_its_tolerance() -> None:
    goal = Pose2(1.0, -1.0, 0.008)
    poses, _ = run(PoseRegulator(goal), Pose2(1.008, -1.0, 0.008), seconds=40.0)
    assert poses[-1].distance(goal) <= 0.008


@settings(max_examples=60, deadline=None)
@given(st.floats(0.0, 0.006), st.floats(-math.pi, math.pi), st.floats(-0.02, 0.02), st.integers(0, 9))
def test_regulator_does_not_chase_a_bearing_that_turns_with_the_base(
    off: float, way: float, sideways: float, seed: int
) -> None:
    """A base that turns about a point beside its origin, near a goal that lies within that circle."""
    middle = Pose2(off * math.cos(way), off * math.sin(way), 0.0)
    origin = Pose2(0.0, 0.0, 0.0).relative_to(middle)
    goal, tolerance = Pose2(1.0, -1.0, 0.5), PoseTolerance(0.003, 0.002)
    regulator, rng = PoseRegulator(goal, tolerance=tolerance), np.random.default_rng(seed)
    pose = seen = goal.compose(Pose2(0.004, sideways, 0.0))
    turned = 0.0
    while not regulator.finished(seen):
        speed, turn_rate = regulator.command(seen, DT)
        turned += abs(turn_rate) * DT
        assert turned < 25.0, f"it turns and turns, {pose.distance(goal):.4f} m beside the goal"
        pose = moved(pose.compose(middle), speed, turn_rate).compose(origin)
        seen = Pose2(*(np.array(pose) + rng.normal(0.0, (5e-4, 5e-4, 3e-4))))
    assert pose.distance(goal) < 0.005


@pytest.mark.parametrize("ahead", [0.008, -0.008])
def test_regulator_drives_the_last_millimetres_the_way_they_lie(ahead: float) -> None:
    tolerance = PoseTolerance(0.003, 0.002)
    poses, _ = run(PoseRegulator(Pose2(0, 0, 0), tolerance=tolerance), Pose2(-ahead, 0.0, 0.0), seconds=10.0)
    assert max(abs(pose.x) for pose in poses) < abs(ahead) + 1e-3
    assert max(abs(pose.theta) for pose in poses) < 0.05


def test_progress_goes_on_while_the_base_rolls_to_rest() -> None:
    tracker = PathTracker(np.array([[0.0, 0.0], [2.0, 0.0]]))
    for x in np.linspace(0.0, 0.5, 11):
        tracker.hold(Pose2(float(x), 0.0, 0.0), DT)
    assert tracker.progress == pytest.approx(0.5)
    assert tracker.ahead[0].tolist() == pytest.approx([0.5, 0.0])


@pytest.mark.parametrize("top", [1.0, 2.0])
def test_fast_robot_stays_on_a_winding_route_and_within_lateral_limit(top: float) -> None:
    limits = DriveLimits(top, 2.1, top, 6.3, 1.5)
    x = np.linspace(0.0, 10.0, 250)
    winding = np.column_stack([x, 0.6 * np.sin(1.2 * x)])
    poses, commands = run(PathTracker(winding, None, limits), Pose2(0.0, 0.05, 0.7))
    assert np.abs(commands[:, 0] * commands[:, 1]).max() <= 1.5 + 1e-9
    assert away_from(winding, poses[20:]) < 0.04  # swinging at 2 m/s was 0.5 m
    assert commands[:, 0].max() > 0.8 * min(top, 1.0)


def test_reroute_hands_the_motion_over_without_a_stop() -> None:
    limits = DriveLimits(1.0, 2.0, 1.0, 6.0)
    tracker, pose = PathTracker(np.array([[0.0, 0.0], [6.0, 0.0]]), None, limits), Pose2(0.0, 0.0, 0.0)
    for _ in range(40):
        speed, turn = tracker.command(pose, DT)
        pose = pose.compose(Pose2(speed * DT, 0.0, turn * DT))
    before = speed
    tracker.reroute(np.array([[pose.x, 0.0], [pose.x + 1.0, 0.1], [6.0, 0.5]]))
    after, _ = tracker.command(pose, DT)
    assert before > 0.9
    assert after > before - 1.0 * DT - 1e-9


@pytest.mark.parametrize("top", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("reverse", [False, True])
def test_tracker_comes_to_rest_at_the_end_itself(top: float, reverse: bool) -> None:
    """Whoever stops short has to aim, drive and turn once more where the place allows little."""
    limits = DriveLimits(speed=top, acceleration=top, turn_rate=2.0, turn_acceleration=6.0)
    points = curve()
    tracker = PathTracker(points, 1.5, limits, reverse, PoseTolerance(0.02, 0.01))
    poses, _ = run(tracker, Pose2(0.0, 0.0, math.pi if reverse else 0.0))
    assert math.dist(poses[-1][:2], points[-1]) < 0.0042


def test_base_that_is_held_before_the_end_turns_to_the_goal() -> None:
    points = np.column_stack([np.linspace(0.0, 1.0, 26), np.zeros(26)])
    tracker = PathTracker(points, 0.0)
    for x in (0.0, 0.5, *[0.99] * 20):
        tracker.command(Pose2(x, 0.0, 0.0), DT)
    assert tracker.closing
