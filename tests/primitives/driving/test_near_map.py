"""The map about the base: a window of a large one, and what was sensed in it."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.primitives.driving import near_map
from handcart.primitives.driving.near_map import NearMap
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

SIZE = (120.0, 30.0)


@pytest.fixture
def grid() -> GridMap:
    return from_boxes([], 0.2, (0.0, 0.0), SIZE)


def pose(x: float) -> Pose2:
    return Pose2(x, 15.0, 0.0)


def test_small_map_is_never_cut(grid: GridMap) -> None:
    near = NearMap(grid, np.empty((0, 4)), 8.0, pose(5.0))
    near.follow(pose(115.0))
    assert near.is_whole
    assert near.layer.merged().occupied.shape == grid.occupied.shape


def test_window_follows_and_sensed_cells_come_back(grid: GridMap, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was sensed is kept while the window is elsewhere, and forgotten by its age there too."""
    monkeypatch.setattr(near_map, "LARGE_MAP_CELLS", 1000)
    near = NearMap(grid, np.empty((0, 4)), 8.0, pose(15.0))
    assert not near.is_whole
    near.layer.add(np.array([[17.1, 15.1]]), 3.0)
    for x in np.arange(15.0, 60.0, 3.0):
        near.follow(pose(float(x)))
    assert not len(near.layer.points)
    assert near.layer.merged().inside(np.array([pose(60.0)[:2]]))[0]
    assert np.allclose(near.all_points(), [[17.1, 15.1]])
    assert np.allclose(near.cells()[:, :2], [[17.1, 15.1]])
    assert not near.forget(2.0)
    for x in np.arange(60.0, 15.0, -3.0):
        near.follow(pose(float(x)))
    assert np.allclose(near.layer.points, [[17.1, 15.1]])
    for x in np.arange(15.0, 60.0, 3.0):
        near.follow(pose(float(x)))
    assert near.forget(4.0)
    assert not len(near.cells())
