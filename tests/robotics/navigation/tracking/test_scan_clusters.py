from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.cluster.hierarchy import fcluster, linkage

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.tracking.scan_clusters import PAIR_DISTANCE_M, cluster_scan
from handcart.robotics.navigation.tracking.seen_free import PastScan, seen_free

LIDAR = np.array([0.0, 0.0])


def leg(x: float, y: float) -> np.ndarray:
    return np.array([[x, y - 0.04], [x - 0.01, y], [x, y + 0.04]])


def test_bodies_are_groups_of_complete_linkage_by_scipy() -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        spots = rng.uniform(1.0, 4.0, (25, 2))
        apart = np.hypot(*(spots[:, None] - spots[None]).transpose(2, 0, 1)) + 9.0 * np.eye(25)
        spots = spots[apart.min(axis=1) > 0.25]  # each leg is a piece of its own
        found = cluster_scan(np.vstack([leg(x, y) for x, y in spots]), LIDAR)
        middles = spots - np.array([0.01 / 3.0, 0.0])
        widths = math.hypot(0.01, 0.08)
        middles += 0.32 * widths * middles / np.hypot(*middles.T)[:, None]
        groups = fcluster(linkage(middles, "complete"), PAIR_DISTANCE_M, "distance")
        labels = found.labels[1::3]
        assert np.array_equal(labels[:, None] == labels, groups[:, None] == groups)
        for group in np.unique(groups):
            centre = middles[groups == group].mean(axis=0)
            assert np.hypot(*(found.centres - centre).T).min() < 1e-9


def test_a_body_over_the_first_and_the_last_beam_is_one_piece() -> None:
    turn = np.radians(np.arange(0.0, 360.0, 2.0))
    ring = 2.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    found = cluster_scan(ring[[0, 1, 2, 60, 61, 178, 179]], LIDAR)
    assert found.labels.tolist() == [0, 0, 0, 1, 1, 0, 0]


def test_a_lone_point_and_a_wall_are_no_bodies() -> None:
    wall = np.column_stack([np.full(30, 2.0), np.linspace(-1.0, 1.0, 30)])
    assert set(cluster_scan(np.vstack([wall, [[0.0, 3.0]]]), LIDAR).labels.tolist()) == {-1}
    assert cluster_scan(np.empty((0, 2)), LIDAR).labels.shape == (0,)


@pytest.mark.parametrize("blind", [math.nan, 1.1])
def test_ground_beside_a_blind_or_short_beam_was_not_seen_free(blind: float) -> None:
    ranges = np.full(181, 3.0)
    ranges[90] = blind
    past = PastScan(0.0, Pose2(0.0, 0.0, 0.0), np.radians(np.arange(-90.0, 91.0)), ranges)
    degrees = np.radians([0.0, 1.0, 2.0, -2.0, 89.0, 90.0, 180.0])
    points = np.column_stack([np.cos(degrees), np.sin(degrees)])
    expected = [False, False, True, True, True, False, False]
    assert seen_free(points, past, 6.0).tolist() == expected


def test_beams_of_a_full_turn_are_neighbours_across_its_end() -> None:
    ranges = np.full(360, math.inf)
    ranges[359] = 0.5
    past = PastScan(0.0, Pose2(1.0, 0.0, math.pi), np.radians(np.arange(-180.0, 180.0)), ranges)
    degrees = np.radians([0.0, 1.0, 2.0, -1.0, -2.0, -3.0])
    points = np.array([1.0, 0.0]) + np.column_stack([np.cos(degrees), np.sin(degrees)])
    assert seen_free(points, past, 6.0).tolist() == [False, True, True, False, False, True]
