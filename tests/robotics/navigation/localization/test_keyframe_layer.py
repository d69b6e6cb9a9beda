"""A pose among the robot's own scans is as uncertain as the keyframe, carried over, and the match."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.keyframe_layer import KeyframeLayer

ROOM = [
    (5.0, 0.0, 0.0, 10.0, 0.2),
    (5.0, 8.0, 0.0, 10.0, 0.2),
    (0.0, 4.0, 0.0, 0.2, 8.0),
    (9.0, 4.0, 0.0, 0.2, 8.0),
]
KEYFRAME = Pose2(4.0, 3.0, 0.2)


@pytest.mark.parametrize("place", [KEYFRAME, Pose2(4.6, 3.5, 0.3)])
def test_covariance_of_a_match_is_the_keyframes_and_its_own(
    place: Pose2, scan: Callable[..., np.ndarray]
) -> None:
    rng = np.random.default_rng(0)
    sure, unsure = np.diag([1e-8, 1e-8, 1e-10]), np.diag([0.1, 0.2, 0.05]) ** 2
    matches = []
    for covariance in (sure, unsure):
        layer = KeyframeLayer()
        assert layer.take(scan(ROOM, KEYFRAME, np.random.default_rng(1)), KEYFRAME, covariance)
        match = layer.match(scan(ROOM, place, np.random.default_rng(2)), place, 0.01)
        assert match is not None
        assert match.pose.distance(place) < 0.02
        matches.append(match.covariance)
    # An error of the keyframe moves and turns the place with it.
    errors = rng.multivariate_normal(np.zeros(3), unsure, 20_000)
    x, y = place.x - KEYFRAME.x, place.y - KEYFRAME.y
    moved = errors + np.column_stack([-y * errors[:, 2], x * errors[:, 2], np.zeros(len(errors))])
    assert matches[1] - matches[0] == pytest.approx(np.cov(moved.T), rel=0.05, abs=4e-4)


def test_scan_far_from_all_keyframes_is_not_matched(scan: Callable[..., np.ndarray]) -> None:
    layer = KeyframeLayer()
    layer.take(scan(ROOM, KEYFRAME, np.random.default_rng(1)), KEYFRAME, np.eye(3) * 1e-4)
    away = Pose2(KEYFRAME.x + 2.0, KEYFRAME.y, KEYFRAME.theta)
    assert layer.match(scan(ROOM, away, np.random.default_rng(2)), away, 0.01) is None
