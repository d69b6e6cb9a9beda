"""Set-points keep the limits, stay on the path and end at rest."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.motion_planner import plan_straight
from handcart.robotics.manipulation.motions.rounded_path import RoundedPath
from handcart.robotics.manipulation.motions.trajectory import time_path

PERIOD = 0.05
VELOCITY = np.full(6, 1.5)
ACCELERATION = np.full(6, 3.0)
READY = np.array([-0.941, -0.9967, 2.3301, -0.9545, -1.4318, 0.1931])


def _assert_limits(points: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, period: float) -> None:
    rest = np.zeros((1, points.shape[1]))
    speeds = np.vstack((rest, np.diff(points, axis=0) / period, rest))
    assert np.all(np.abs(speeds) <= velocity * (1 + 1e-9))
    assert np.all(np.abs(np.diff(speeds, axis=0)) / period <= acceleration * (1 + 1e-9))


def _off_path(points: np.ndarray, path: np.ndarray) -> float:
    """Largest distance of the points (k, n) from the polyline `path` (m, n)."""
    starts, steps = path[:-1], np.diff(path, axis=0)
    squared = np.maximum(np.sum(steps**2, axis=1), 1e-300)
    share = np.clip(np.einsum("kmn,mn->km", points[:, None] - starts, steps) / squared, 0.0, 1.0)
    nearest = starts + share[..., None] * steps
    return float(np.max(np.min(np.linalg.norm(points[:, None] - nearest, axis=2), axis=1)))


@pytest.mark.slow
@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    corners=st.integers(2, 9),
    size=st.sampled_from([1e-6, 1e-3, 0.05, 1.0, 3.0]),
    period=st.sampled_from([0.01, 0.05, 0.1]),
)
def test_random_paths(seed: int, corners: int, size: float, period: float) -> None:
    rng = np.random.default_rng(seed)
    path = rng.uniform(-size, size, (corners, 6))
    velocity, acceleration = rng.uniform(0.3, 2.0, 6), rng.uniform(0.5, 5.0, 6)
    points = time_path(path, velocity, acceleration, period)
    np.testing.assert_allclose(points[[0, -1]], path[[0, -1]], atol=1e-9)
    _assert_limits(points, velocity, acceleration, period)
    assert _off_path(points, path) <= 0.005 + 1e-9


@settings(max_examples=15, deadline=None, derandomize=True)
@given(length=st.floats(0.02, 3.0))
@example(length=1.0)
def test_one_line_is_nearly_as_fast_as_can_be(length: float) -> None:
    points = time_path(np.array([np.zeros(6), np.full(6, length)]), VELOCITY, ACCELERATION, PERIOD)
    ideal = length / 1.5 + 1.5 / 3.0 if length > 0.75 else 2.0 * np.sqrt(length / 3.0)
    assert ideal - 1e-9 <= (len(points) - 1) * PERIOD <= ideal + 3 * PERIOD


def test_dense_path_is_not_stopped_at_each_point(arm: ArmModel) -> None:
    path = plan_straight(arm, READY, transform((0.14, 0.42, 0.79)))
    assert path is not None
    points = time_path(path, VELOCITY, ACCELERATION, PERIOD)
    _assert_limits(points, VELOCITY, ACCELERATION, PERIOD)
    fastest_joint = float(np.max(np.sum(np.abs(np.diff(path, axis=0)), axis=0)))
    assert (len(points) - 1) * PERIOD < 1.6 * (fastest_joint / 1.5 + 0.5)
    hands = np.array([arm.forward(q)[:3, 3] for q in points])
    np.testing.assert_allclose(hands[:, [0, 2]], np.tile([0.14, 0.79], (len(hands), 1)), atol=1e-4)


def test_reversal_stops_and_comes_back() -> None:
    path = np.array([np.zeros(6), np.full(6, 0.5), np.zeros(6)])
    points = time_path(path, VELOCITY, ACCELERATION, PERIOD)
    _assert_limits(points, VELOCITY, ACCELERATION, PERIOD)
    assert np.max(points) == pytest.approx(0.5)


def test_nothing_to_move() -> None:
    still = np.array([READY, READY, READY])
    np.testing.assert_array_equal(time_path(still, VELOCITY, ACCELERATION, PERIOD), [READY])


def test_limits_above_zero_are_asked_for() -> None:
    with pytest.raises(ValueError, match="above zero"):
        time_path(np.zeros((2, 6)), VELOCITY, 0.0 * ACCELERATION, PERIOD)


def test_rounded_path_derivatives_and_ends() -> None:
    corners = np.random.default_rng(1).uniform(-1.0, 1.0, (6, 4))
    rounded = RoundedPath(corners, deviation=0.02)
    np.testing.assert_allclose(rounded.at(np.array([0.0, rounded.length])), corners[[0, -1]], atol=1e-12)
    inner = np.random.default_rng(2).uniform(0.0, rounded.length, 200)
    inner = inner[np.min(np.abs(inner[:, None] - rounded.knots), axis=1) > 1e-4]
    h = 1e-5
    slope = (rounded.at(inner + h) - rounded.at(inner - h)) / (2 * h)
    np.testing.assert_allclose(rounded.at(inner, order=1), slope, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(slope, axis=1), 1.0, atol=1e-6)
    bend = (rounded.at(inner + h, order=1) - rounded.at(inner - h, order=1)) / (2 * h)
    np.testing.assert_allclose(rounded.at(inner, order=2), bend, rtol=1e-5, atol=1e-5)


def test_rounded_path_stays_within_the_deviation() -> None:
    corners = np.random.default_rng(3).uniform(-1.0, 1.0, (8, 6))
    rounded = RoundedPath(corners, deviation=0.02)
    off = _off_path(rounded.at(np.linspace(0.0, rounded.length, 5000)), corners)
    assert 0.01 < off <= 0.02 + 1e-9


@pytest.mark.slow
def test_plots_of_the_library_are_not_loaded() -> None:
    code = "import sys, handcart.robotics.manipulation.motions.path_speed; print('matplotlib' in sys.modules)"
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert shown.stdout == "False\n"


def test_limits_of_an_earlier_path_do_not_hold_for_the_next() -> None:
    path = np.array([np.zeros(6), np.full(6, 0.4)])
    lengths = []
    for velocity, acceleration in ((1.0, 1.0), (0.25, 1.0), (0.25, 0.5), (1.0, 1.0)):
        limits = VELOCITY * velocity, ACCELERATION * acceleration
        points = time_path(path, *limits, PERIOD)
        _assert_limits(points, *limits, PERIOD)
        lengths.append(len(points))
    assert lengths[0] == lengths[3] < lengths[1] < lengths[2]
