from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.scans.front_line import fit_front, pose_from_front

SHELF = np.array([[-0.5, 0.0], [0.5, 0.0]])  # a front of 1 m on the map's x axis; the robot is south of it


def beams(pose: Pose2, rng: np.random.Generator, scans: int = 1, sigma: float = 0.01) -> np.ndarray:
    """Scan points (n, 2) on the shelf's front, base frame, 1 degree apart, noise along the beam."""
    angles = np.tile(np.radians(np.arange(360.0)), scans) + pose.theta
    with np.errstate(divide="ignore"):
        reach = -pose.y / np.sin(angles)
    on = (reach > 0) & (np.abs(pose.x + reach * np.cos(angles)) < 0.5)
    reach = reach[on] + rng.normal(0.0, sigma, on.sum())
    return np.column_stack([reach * np.cos(angles[on] - pose.theta), reach * np.sin(angles[on] - pose.theta)])


def expected(pose: Pose2) -> np.ndarray:
    return pose.inverse().apply(SHELF)


@pytest.mark.slow
def test_accuracy_at_one_centimetre_of_noise() -> None:
    """A second and a half of scans at rest: 0.7 mm and 0.04 degrees, and deviations that say so."""
    rng = np.random.default_rng(0)
    distance, angle, ratios = [], [], []
    for _ in range(100):
        truth = Pose2(rng.uniform(-0.1, 0.1), -0.6, math.pi / 2 + rng.uniform(-0.1, 0.1))
        front = fit_front(beams(truth, rng, scans=30), expected(truth))
        assert front is not None
        distance.append(front.distance - 0.6)
        angle.append(wrap(front.angle - (math.pi / 2 - truth.theta)))
        ratios.append((distance[-1] / front.distance_std, angle[-1] / front.angle_std))
    assert np.mean(np.abs(distance)) < 0.0007
    assert np.degrees(np.mean(np.abs(angle))) < 0.05
    assert np.all(np.abs(np.std(ratios, axis=0) - 1.0) < 0.25)


def test_a_pose_is_corrected_across_the_front_and_in_heading_only() -> None:
    rng = np.random.default_rng(1)
    truth = Pose2(0.05, -0.6, math.pi / 2 + 0.02)
    guess = Pose2(0.08, -0.57, math.pi / 2 - 0.03)
    front = fit_front(beams(truth, rng, scans=10), expected(guess))
    assert front is not None
    mended = pose_from_front(guess, front, SHELF)
    assert mended.x == pytest.approx(guess.x)
    assert mended.y == pytest.approx(truth.y, abs=0.002)
    assert mended.theta == pytest.approx(truth.theta, abs=math.radians(0.2))


@settings(max_examples=50)
@given(st.floats(-math.pi, math.pi), st.floats(-3, 3), st.floats(-3, 3))
def test_exact_points_give_the_exact_pose_wherever_the_shelf_stands(turn: float, x: float, y: float) -> None:
    world_T_shelf = Pose2(x, y, turn)
    local = Pose2(0.1, -0.7, 1.7)
    truth, segment = world_T_shelf.compose(local), world_T_shelf.apply(SHELF)
    front = fit_front(beams(local, np.random.default_rng(0), sigma=0.0), expected(local))
    assert front is not None
    mended = pose_from_front(truth.compose(Pose2(0.03, 0.0, 0.05)), front, segment)
    assert mended.turn(truth) < 1e-6
    assert abs(world_T_shelf.inverse().compose(mended).y + 0.7) < 1e-6


def test_a_box_in_front_is_left_out() -> None:
    rng = np.random.default_rng(2)
    truth = Pose2(0.0, -0.6, math.pi / 2)
    points = beams(truth, rng, scans=4)
    covered = points[:, 1] > 0.15
    points[covered] *= 0.9
    front = fit_front(points, expected(truth))
    assert front is not None
    assert front.distance == pytest.approx(0.6, abs=0.003)
    assert abs(front.angle) < math.radians(0.5)


def test_too_few_points_make_no_line() -> None:
    truth = Pose2(0.0, -0.6, math.pi / 2)
    assert fit_front(np.empty((0, 2)), expected(truth)) is None
    assert fit_front(beams(truth, np.random.default_rng(0))[:8], expected(truth)) is None


def test_a_front_that_is_not_where_it_should_be_is_not_found() -> None:
    truth = Pose2(0.0, -0.6, math.pi / 2)
    points = beams(truth, np.random.default_rng(0))
    assert fit_front(points, expected(Pose2(0.0, -1.0, math.pi / 2))) is None


def test_how_exact_a_front_is_follows_from_its_points() -> None:
    """Least squares by hand: 41 points over 2 m, 1 m ahead, each of 10 mm."""
    at = np.linspace(-1.0, 1.0, 41)
    points = np.column_stack([np.ones(41), at])
    front = fit_front(points, np.array([[1.0, -1.2], [1.0, 1.2]]))
    assert front is not None
    assert (front.distance, front.angle, front.inliers) == pytest.approx((1.0, 0.0, 41))
    assert front.distance_std == pytest.approx(0.01 / math.sqrt(41.0))
    assert front.angle_std == pytest.approx(0.01 / math.sqrt(float((at**2).sum())))


def test_a_front_on_one_side_is_less_exact_by_its_lever() -> None:
    at = np.linspace(1.0, 2.0, 21)
    front = fit_front(np.column_stack([np.ones(21), at]), np.array([[1.0, 0.8], [1.0, 2.2]]))
    assert front is not None
    angle = 0.01 / math.sqrt(float(((at - 1.5) ** 2).sum()))
    assert front.angle_std == pytest.approx(angle)
    assert front.distance_std == pytest.approx(math.hypot(0.01 / math.sqrt(21.0), 1.5 * angle))


@pytest.mark.parametrize(("count", "found"), [(11, False), (12, True)])
def test_a_front_needs_twelve_points(count: int, found: bool) -> None:
    points = np.column_stack([np.ones(count), np.linspace(-0.5, 0.5, count)])
    assert (fit_front(points, np.array([[1.0, -1.0], [1.0, 1.0]])) is not None) == found


@pytest.mark.parametrize(("away", "end", "inliers"), [(0.099, 0.94, 30), (0.101, 0.94, 0), (0.0, 0.96, 29)])
def test_points_beyond_gate_and_margin_are_no_front(away: float, end: float, inliers: int) -> None:
    points = np.column_stack([np.full(30, 1.0 + away), np.append(np.linspace(-0.9, 0.9, 29), end)])
    front = fit_front(points, np.array([[1.0, -1.0], [1.0, 1.0]]))
    assert (0 if front is None else front.inliers) == inliers
