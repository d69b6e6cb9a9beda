"""Masks over a map, after nav2's costmap filters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.keepout import keepout_cells, with_keepout
from handcart.robotics.navigation.maps.speed_limits import SpeedLimits


def chart(
    shape: tuple[int, int],
    resolution: float,
    origin: tuple[float, float] = (0.0, 0.0),
    occupied: Sequence[tuple[int, int]] = (),
) -> GridMap:
    cells = np.zeros(shape, dtype=bool)
    for pair in occupied:
        cells[pair] = True
    return GridMap(cells, np.zeros(shape, dtype=bool), resolution, *origin)


def test_a_zone_is_unknown_and_no_wall() -> None:
    grid = chart((4, 6), 0.5, occupied=[(0, 0)])
    zones = chart((4, 6), 0.5, occupied=[(0, 0), (2, 3)])
    masked = with_keepout(grid, zones)
    assert np.array_equal(masked.occupied, grid.occupied)
    assert np.argwhere(masked.unknown).tolist() == [[2, 3]]


@pytest.mark.parametrize("resolution", [0.1, 0.25, 0.5, 0.8, 2.0])
def test_zones_have_cells_of_any_size_from_any_origin(resolution: float) -> None:
    """Every cell whose centre a zone covers, and every cell that holds a zone's centre, and no others."""
    grid = chart((20, 30), 0.5, (-3.0, 1.0))
    rng = np.random.default_rng(7)
    shape = (int(12 / resolution), int(12 / resolution))
    zones = chart(shape, resolution, (-1.3, 2.7))
    zones.occupied[rng.random(shape) < 0.05] = True
    barred = keepout_cells(grid, zones)
    held = {tuple(cell) for cell in grid.to_cell(zones.to_point(np.argwhere(zones.occupied))).tolist()}
    for cell in np.ndindex(barred.shape):
        centre = grid.to_point(np.array([cell]))
        covered = zones.inside(centre)[0] and zones.occupied[tuple(zones.to_cell(centre)[0])]
        assert barred[cell] == (covered or cell in held)


def limits(
    values: list[int], percent: bool = True, base: float = 100.0, multiplier: float = -1.0
) -> SpeedLimits:
    return SpeedLimits(np.array([values], dtype=np.int8), 1.0, (0.0, 0.0), percent, base, multiplier)


def test_limits_are_those_of_nav2() -> None:
    """speed_filter.cpp: 0, unknown, beyond the mask and what can't be are no limit."""
    cells = np.array([[x + 0.5, 0.5] for x in range(6)])
    assert limits([0, -1, 20, 50, 100]).at(cells, 2.0).tolist() == pytest.approx(
        [2.0, 2.0, 1.6, 1.0, 2.0, 2.0]
    )
    assert limits([1, 100], base=0.0, multiplier=1.0).at(cells[:2], 2.0).tolist() == pytest.approx(
        [0.02, 2.0]
    )
    absolute = limits([10, 20, 100], percent=False, base=0.0, multiplier=0.01)
    assert absolute.at(cells[:3], 0.5).tolist() == pytest.approx([0.1, 0.2, 0.5])
    assert limits([10], percent=False, base=-1.0).at(cells[:1], 0.5).tolist() == [0.5]


def test_a_robot_is_never_faster_in_a_zone_than_allowed() -> None:
    """It brakes before, and is as fast as ever elsewhere."""
    drive = DriveLimits(speed=1.0, acceleration=0.5)
    slow = limits([0, 0, 0, 80, 80, 0, 0, 0])
    for allowed, least in ((slow, 0.2), (None, 0.9)):
        tracker = PathTracker(np.array([[0.0, 0.5], [8.0, 0.5]]), 0.0, drive, allowed=allowed)
        pose, seen = Pose2(0.0, 0.5, 0.0), []
        while not tracker.finished(pose):
            speed, turn = tracker.command(pose, 0.05)
            seen.append((pose.x, speed))
            pose = pose.compose(Pose2(speed * 0.05, 0.0, turn * 0.05))
        inside = [speed for x, speed in seen if 3.0 <= x <= 5.0]
        assert max(inside) == pytest.approx(least, abs=0.1)
        assert max(inside) <= 0.2 + 1e-9 or allowed is None
        assert max(speed for x, speed in seen if x < 3.0) > 0.7
