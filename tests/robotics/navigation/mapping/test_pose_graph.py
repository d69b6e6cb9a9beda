"""Covariances of a pose graph against many noisy ones, and what must not depend on the frame."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.keyframe_graph import _in_frame_of
from handcart.robotics.navigation.mapping.pose_graph import (
    Edge,
    covariances,
    edge_errors,
    factorized,
    optimize,
    relative_covariances,
)
from handcart.robotics.numerics.arrays import FloatArray

TRUE = [Pose2(0.0, 0.0, 0.3)]
for _step in (Pose2(1.0, 0.1, 0.5), Pose2(1.2, 0.0, 0.7), Pose2(0.8, -0.2, 0.9), Pose2(1.0, 0.0, 0.6)):
    TRUE.append(TRUE[-1].compose(_step))
PAIRS = ((0, 1), (1, 2), (2, 3), (3, 4), (0, 3))
SPREAD = np.array([[4e-4, 2e-4, 1e-4], [2e-4, 9e-4, -2e-4], [1e-4, -2e-4, 3e-4]])
"""Covariance of each edge in the frame of its first node, with x, y and heading correlated."""


def noisy_edges(rng: np.random.Generator) -> list[Edge]:
    information = np.linalg.inv(SPREAD)
    found = []
    for one, other in PAIRS:
        exact, error = TRUE[other].relative_to(TRUE[one]), rng.multivariate_normal(np.zeros(3), SPREAD)
        found.append(Edge(one, other, Pose2(*np.add(exact, error).tolist()), information))
    return found


@cache
def sampled_poses(count: int = 300) -> FloatArray:
    """(count, n, 3) optimal poses by noisy edges; the first is always the same."""
    rng = np.random.default_rng(0)
    start = np.array(TRUE)
    return np.array([optimize(start, noisy_edges(rng), robust=False) for _ in range(count)])


EXACT = [Edge(one, other, TRUE[other].relative_to(TRUE[one]), np.linalg.inv(SPREAD)) for one, other in PAIRS]


def assert_alike(claimed: FloatArray, sampled: FloatArray) -> None:
    """Assert that covariances (3, 3) agree to a quarter, signs of correlations included."""
    size = np.sqrt(np.outer(np.diag(sampled), np.diag(sampled)))
    assert np.abs((claimed - sampled) / size).max() < 0.25, (claimed, sampled)


@pytest.mark.slow
def test_covariances_are_those_of_many_noisy_graphs() -> None:
    claimed = covariances(np.array(TRUE), EXACT)
    for node in range(1, len(TRUE)):
        assert_alike(claimed[node], np.cov(sampled_poses()[:, node].T))


def relative_poses(second: int, first: int) -> FloatArray:
    """(count, 3) poses of one node in the frame of another, in each noisy graph."""
    pairs = ((Pose2(*one[second].tolist()), Pose2(*one[first].tolist())) for one in sampled_poses())
    return np.array([pose.relative_to(frame) for pose, frame in pairs])


def test_relative_covariances_are_those_of_many_noisy_graphs() -> None:
    poses, node = np.array(TRUE), 4
    claimed = relative_covariances(factorized(poses, EXACT), poses, node, covariances(poses, EXACT))
    cos, sin = math.cos(TRUE[node].theta), math.sin(TRUE[node].theta)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    for number in (1, 2, 3):
        assert_alike(claimed[number], turn @ np.cov(relative_poses(number, node).T) @ turn.T)
        moved = _in_frame_of(claimed[number], poses[node], poses[number])
        assert_alike(moved - np.diag([0.05, 0.05, 0.02]) ** 2, np.cov(relative_poses(node, number).T))


@settings(max_examples=20, deadline=None)
@given(x=st.floats(-50, 50), y=st.floats(-50, 50), heading=st.floats(-3.1, 3.1), seed=st.integers(0, 1000))
def test_graph_does_not_depend_on_the_frame(x: float, y: float, heading: float, seed: int) -> None:
    edges, frame = noisy_edges(np.random.default_rng(seed)), Pose2(x, y, heading)
    here = optimize(np.array(TRUE), edges)
    there = optimize(np.array([frame.compose(pose) for pose in TRUE]), edges)
    for one, other in zip(here.tolist(), there.tolist(), strict=True):
        assert frame.compose(Pose2(*one)).distance(Pose2(*other)) < 1e-4
        assert frame.compose(Pose2(*one)).turn(Pose2(*other)) < 1e-4


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000), far=st.floats(2.0, 30.0), direction=st.floats(-3.1, 3.1))
def test_one_wrong_closure_does_not_move_the_graph(seed: int, far: float, direction: float) -> None:
    edges = noisy_edges(np.random.default_rng(seed))
    right = optimize(np.array(TRUE), edges)
    off = Pose2(far * math.cos(direction), far * math.sin(direction), 0.0)
    wrong = Edge(0, 4, TRUE[4].relative_to(TRUE[0]).compose(off), np.linalg.inv(SPREAD), is_loop=True)
    moved = optimize(np.array(TRUE), [*edges, wrong])
    assert np.abs(moved - right)[:, :2].max() < 0.05
    assert edge_errors(moved, [wrong])[0] > 100.0
