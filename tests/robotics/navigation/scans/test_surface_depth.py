"""Shift of a pose if all surfaces lie at the front of their cells."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import from_boxes
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField, match_scan
from handcart.robotics.navigation.scans.surface_depth import depth_shifts

from ..conftest import Boxes

FAR_WALLS: Boxes = [(8.05, 0.0, 0.0, 0.1, 12.0), (1.0, 3.05, 0.0, 14.0, 0.1)]
NEAR_WALLS: Boxes = [(-2.05, 0.0, 0.0, 0.1, 12.0), (1.0, -3.05, 0.0, 14.0, 0.1)]


@pytest.mark.parametrize("walls", [FAR_WALLS, [*FAR_WALLS, NEAR_WALLS[1]], [*FAR_WALLS, *NEAR_WALLS]])
@pytest.mark.parametrize("pose", [Pose2(5.0, 1.0, 0.3), Pose2(1.0, -1.0, 2.0)])
def test_the_shift_is_the_error_of_a_map_of_cell_borders(
    walls: Boxes, pose: Pose2, scan: Callable[..., np.ndarray]
) -> None:
    field = LikelihoodField(from_boxes(walls, 0.05, (-4.0, -7.0), (14.0, 14.0)))
    points = scan(walls, pose, np.random.default_rng(3), 0.002)
    match = match_scan(field, points, pose, np.diag([0.05, 0.05, 0.02]) ** 2)
    error = np.subtract(match.pose[:2], pose[:2])
    assert np.abs(error) == pytest.approx(np.abs(depth_shifts(field, points, match.pose)[0]), abs=0.006)


def test_walls_that_lie_anywhere_in_their_cells_shift_on_their_own(scan: Callable[..., np.ndarray]) -> None:
    """One wall is at the front of its cells and the opposite one at their back: half a cell."""
    walls = [*FAR_WALLS, *NEAR_WALLS]
    pose = Pose2(1.0, -1.0, 0.4)
    field = LikelihoodField(from_boxes(walls, 0.05, (-4.0, -7.0), (14.0, 14.0)))
    moved = [(x + (0.049 if x > 4.0 else 0.0), y, a, b, c) for x, y, a, b, c in walls]
    points = scan(moved, pose, np.random.default_rng(3), 0.002)
    match = match_scan(field, points, pose, np.diag([0.05, 0.05, 0.02]) ** 2)
    alike, *apart = np.abs(depth_shifts(field, points, match.pose)[:, 0])
    assert alike < 0.01
    assert alike + 0.006 < abs(match.pose.x - pose.x) < sum(apart)


def test_points_that_no_wall_explains_shift_nothing() -> None:
    field = LikelihoodField(from_boxes(FAR_WALLS, 0.05, (-4.0, -7.0), (14.0, 14.0)))
    assert depth_shifts(field, np.empty((0, 2)), Pose2(0.0, 0.0, 0.0)) == pytest.approx(np.zeros((9, 2)))
    assert depth_shifts(field, np.full((9, 2), 0.3), Pose2(0.0, 0.0, 0.0)) == pytest.approx(np.zeros((9, 2)))
