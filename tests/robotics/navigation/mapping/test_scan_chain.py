"""The chain of keyframes: edges whose information is that of the matches."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.pose_graph import covariances, edge_errors
from handcart.robotics.navigation.mapping.scan_chain import chain
from handcart.robotics.navigation.mapping.scan_log import ScanLog, keyframe

WALLS = [(x, 0.0, 0.0, 0.1, 6.0) for x in (-1.0, 9.0)] + [(4.0, y, 0.0, 10.0, 0.1) for y in (-3.0, 3.0)]
WALLS += [(float(x), 2.4, 0.3, 0.6, 0.5) for x in range(0, 9, 2)]
COUNT = 25


def straight_log(seed: int) -> ScanLog:
    """Scans along 7.5 m of a room, with odometry that errs."""
    rng = np.random.default_rng(seed)
    angles = np.radians(np.arange(-180.0, 180.0, 2.0))
    poses = [Pose2(0.3 * number, 0.0, 0.0) for number in range(COUNT)]
    ranges = np.array([box_ranges(WALLS, pose, angles) for pose in poses])
    ranges += rng.normal(0.0, 0.01, ranges.shape)
    odometry = np.array(poses) + np.cumsum(rng.normal(0.0, [0.01, 0.01, 0.01], (COUNT, 3)), axis=0)
    odometry -= odometry[0]
    times = np.arange(COUNT, dtype=np.float64)
    return ScanLog(times, odometry, angles, ranges, Pose2(0.0, 0.0, 0.0), 20.0)


def squared_error(seed: int, factor: float = 1.0) -> float:
    """Return the mean squared error of the chain's poses in claimed sigmas; 3 if the claims are exact.

    `factor` of the information that the edges claim.
    """
    log = straight_log(seed)
    poses, edges, blind = chain([keyframe(log, row) for row in range(COUNT)])
    assert blind == 0
    assert edge_errors(np.array(poses), edges).max() < 1e-12
    edges = [edge._replace(information=factor * edge.information) for edge in edges]
    claimed = covariances(np.array(poses), edges)[1:]
    off = np.array(poses)[1:] - np.array([[0.3 * number, 0.0, 0.0] for number in range(1, COUNT)])
    return float(np.einsum("ni,nij,nj->n", off, np.linalg.inv(claimed), off).mean())


@pytest.mark.slow
def test_claimed_errors_of_a_chain_are_never_too_small() -> None:
    """Nor much too large: a match with ten keyframes drifts less than ten independent ones (0.46)."""
    assert 0.6 < np.mean([squared_error(seed) for seed in range(6)]) < 3.0


@pytest.mark.slow
def test_claims_a_tenth_as_large_would_be_found_out() -> None:
    assert np.mean([squared_error(seed, 100.0) for seed in range(6)]) > 10.0
