from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField
from handcart.robotics.navigation.scans.unexpected import path_blocked, unexpected_points
from tests.robotics.navigation.conftest import Boxes

ROUTE = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]])


def test_a_scan_of_what_the_map_shows_is_expected(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    pose = Pose2(3.0, 3.5, 1.0)
    points = pose.apply(scan(library_boxes, pose, np.random.default_rng(0)))
    assert len(unexpected_points(points, library_field, 0.1)) == 0


def test_a_box_that_the_map_does_not_show_is_unexpected(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    pose = Pose2(3.0, 3.5, 1.0)
    points = pose.apply(scan([*library_boxes, (4.4, 3.5, 0.2, 0.4, 0.4)], pose, np.random.default_rng(0)))
    found = unexpected_points(points, library_field, 0.1)
    assert len(found) > 10
    assert np.hypot(*(found - (4.4, 3.5)).T).max() < 0.35


def test_where_the_map_knows_nothing_anything_may_stand() -> None:
    unknown = np.zeros((40, 40), dtype=bool)
    unknown[20:] = True
    occupied = np.zeros((40, 40), dtype=bool)
    occupied[0, 0] = True
    field = LikelihoodField(GridMap(occupied, unknown, 0.05, 0.0, 0.0))
    found = unexpected_points(np.array([[1.0, 1.5], [1.0, 0.5], [9.0, 9.0]]), field, 0.1)
    assert found.tolist() == [[1.0, 0.5]]


def test_no_points_are_no_surprise(library_field: LikelihoodField) -> None:
    assert unexpected_points(np.empty((0, 2)), library_field, 0.1).shape == (0, 2)


def test_a_route_is_blocked_where_the_robot_would_touch() -> None:
    found = path_blocked(ROUTE, np.array([[2.0, 0.1], [2.02, 0.12]]), 0.4, 5.0)
    assert found is not None
    distance, point = found
    assert distance == pytest.approx(2.0 - np.sqrt(0.4**2 - 0.1**2), abs=0.05)
    assert point.tolist() == [2.0, 0.1]


def test_distance_is_along_the_route() -> None:
    found = path_blocked(ROUTE, np.array([[3.0, 2.0], [3.05, 2.0]]), 0.4, 10.0)
    assert found is not None
    assert found[0] == pytest.approx(4.6, abs=0.05)


@pytest.mark.parametrize(
    ("points", "horizon"),
    [
        (np.array([[1.5, 0.6], [1.5, 0.7]]), 10.0),
        (np.array([[3.0, 2.0], [3.0, 2.1]]), 2.0),
        (np.array([[1.5, 0.0]]), 10.0),
        (np.array([[1.5, 0.0], [1.5, 0.9], [0.5, -1.2]]), 10.0),
        (np.empty((0, 2)), 10.0),
        (np.array([[-0.3, 0.0], [-0.28, 0.1]]), 10.0),
        (np.array([[0.0, 0.35], [0.0, 0.36]]), 0.3),
    ],
    ids=["beside", "beyond the horizon", "a lone point", "lone among others", "nothing", "behind", "aside"],
)
def test_a_route_is_not_blocked_by(points: NDArray[Any], horizon: float) -> None:
    assert path_blocked(ROUTE, points, 0.4, horizon) is None


def test_what_is_too_near_ahead_blocks_at_once() -> None:
    found = path_blocked(ROUTE, np.array([[0.3, 0.0], [0.3, 0.1]]), 0.4, 1.0)
    assert found is not None
    assert found[0] == 0.0


def test_no_route_is_never_blocked() -> None:
    assert path_blocked(np.empty((0, 2)), np.zeros((5, 2)), 0.4, 1.0) is None
