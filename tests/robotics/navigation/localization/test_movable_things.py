"""A table that was moved against the map has no part in the pose, nor in its claimed covariance."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.localizer import LEAST_INLIERS, ScanLocalizer
from handcart.robotics.navigation.localization.odometry_localizer import OdometryLocalizer
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.maps.movable_areas import MovableArea, with_movable
from handcart.robotics.navigation.odometry.odometry import OdometryErrors
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_matching import ScanMatch, match_scan
from handcart.robotics.navigation.scans.surface_depth import depth_shifts

from ..conftest import Boxes

WALLS: Boxes = [
    (3.01, 0.02, 0.0, 6.0, 0.1),
    (5.98, 2.2, 0.0, 0.1, 4.5),
    (3.01, 4.51, 0.0, 6.0, 0.1),
    (0.02, 2.2, 0.0, 0.1, 4.5),
]
TABLE = (2.0, 3.8, 0.0, 1.2, 0.6)
MOVED = (2.02, 3.778, math.radians(3.0), 1.2, 0.6)
BEFORE_IT = Pose2(2.0, 2.9, math.pi / 2)
PRIOR = np.diag([0.05, 0.05, 0.035]) ** 2


def map_with(boxes: Boxes, is_movable: bool) -> GridMap:
    grid = from_boxes(boxes, 0.05, (-0.5, -0.5), (7.0, 5.5))
    x, y, _, length, width = TABLE
    half = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * (length / 2, width / 2)
    return with_movable(grid, [MovableArea(half + np.array([x, y]), 0.2)]) if is_movable else grid


def matched(grid: GridMap, boxes: Boxes, scan: Callable[..., np.ndarray], is_far: bool = False) -> ScanMatch:
    points = scan(boxes, BEFORE_IT, np.random.default_rng(5))
    ahead = points[points[:, 0] > -0.1]  # half a turn: most of it is the table
    prior = Pose2(BEFORE_IT.x + 0.03, BEFORE_IT.y - 0.02, BEFORE_IT.theta + 0.02)
    return match_scan(LikelihoodField(grid), ahead, prior, PRIOR, anneal=is_far)


def error_of(match: ScanMatch) -> np.ndarray:
    x, y, turn = np.subtract(match.pose, BEFORE_IT).tolist()
    return np.array([x, y, wrap(turn)])


@pytest.mark.parametrize("is_far", [False, True])
def test_moved_table_pulls_the_pose_only_if_it_counts(is_far: bool, scan: Callable[..., np.ndarray]) -> None:
    mapped, real = [*WALLS, TABLE], [*WALLS, MOVED]
    error = error_of(counts := matched(map_with(mapped, False), real, scan, is_far))
    assert math.hypot(*error[:2]) > 0.035
    assert float(error @ np.linalg.solve(counts.covariance, error)) > 11.3  # its claim denies it: 99 %
    error = error_of(match := matched(map_with(mapped, True), real, scan, is_far))
    assert math.hypot(*error[:2]) < 0.02
    assert float(error @ np.linalg.solve(match.covariance, error)) < 9.0
    assert abs(error[2]) < math.radians(0.3)
    assert match.inliers > 0.95
    assert len(match.residuals) < 0.7 * len(counts.residuals)


def test_where_the_table_is_does_not_change_the_pose(scan: Callable[..., np.ndarray]) -> None:
    grid = map_with([*WALLS, TABLE], True)
    one, other = (matched(grid, [*WALLS, table], scan) for table in (TABLE, MOVED))
    assert one.pose.distance(other.pose) < 0.004
    assert one.covariance == pytest.approx(other.covariance, rel=0.1, abs=1e-6)


def test_table_alone_determines_nothing(scan: Callable[..., np.ndarray]) -> None:
    match = matched(map_with([TABLE], True), [MOVED], scan)
    assert match.covariance == pytest.approx(PRIOR, rel=1e-6)
    assert match.inliers == 0.0
    points = scan([MOVED], BEFORE_IT, np.random.default_rng(5))
    shifts = depth_shifts(LikelihoodField(map_with([TABLE], True)), points, BEFORE_IT)
    assert shifts == pytest.approx(np.zeros((9, 2)))
    assert np.abs(depth_shifts(LikelihoodField(map_with([TABLE], False)), points, BEFORE_IT)).max() > 0.01


def test_few_points_of_walls_beside_a_table_are_too_few(scan: Callable[..., np.ndarray]) -> None:
    field = LikelihoodField(map_with([*WALLS, TABLE], True))
    points = scan([*WALLS, TABLE], BEFORE_IT, np.random.default_rng(5))
    free = field.fixed(points, BEFORE_IT)
    table = points[points[:, 0] > 0.0][np.abs(points[points[:, 0] > 0.0][:, 1]) < 0.4]
    match = match_scan(field, np.vstack([table, free[::60][:5]]), BEFORE_IT, PRIOR)
    assert len(match.residuals) == 5
    assert 0.0 < match.inliers < LEAST_INLIERS


def test_localizer_before_a_table_alone_is_unsure_and_not_lost(scan: Callable[..., np.ndarray]) -> None:
    rng, field = np.random.default_rng(5), LikelihoodField(map_with([TABLE], True))
    localizer = ScanLocalizer(field, BEFORE_IT, 0.4, OdometryErrors(), PRIOR)
    for _ in range(12):  # two more than its patience
        localizer.predict(0.02, 0.02)
        points = scan([MOVED], localizer.pose, rng)
        localizer.correct(points)
        assert not localizer.find_again(points)
    assert not localizer.lost
    assert np.all(np.diag(localizer.covariance) >= 0.9 * np.diag(PRIOR))


def test_wheels_alone_are_not_corrected_by_a_moved_table(scan: Callable[..., np.ndarray]) -> None:
    rng, field = np.random.default_rng(5), LikelihoodField(map_with([TABLE], True))
    localizer = OdometryLocalizer(BEFORE_IT, 0.4, covariance=PRIOR, field=field)
    points = scan([MOVED], BEFORE_IT, rng)
    localizer.check_drive(points)
    assert localizer.pose == BEFORE_IT and localizer.slips == 0
    assert not localizer.find_again(points) and not localizer.find_again(scan([MOVED], BEFORE_IT, rng))
    assert localizer.pose == BEFORE_IT
