"""Free travel of a disc, compared with a sweep in tiny steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.way_guard import NO_STANDS, WayGuard
from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray

NEEDED = 0.3
WALL = GridMap(
    np.eye(1, 40, 39, dtype=np.bool_).repeat(40, axis=0), np.zeros((40, 40), np.bool_), 0.1, 0.0, 0.0
)
"""The cells from x = 3.9 m on."""


def swept(pose: Pose2, curvature: float, length: float) -> FloatArray:
    """Middles (n, 2) along an arc, a millimetre apart."""
    along = np.arange(0.0, abs(length), 0.001) * math.copysign(1.0, length)
    turn = curvature * along
    local = np.column_stack(
        [along * np.sinc(turn / np.pi), along * np.sinc(turn / 2 / np.pi) * np.sin(turn / 2)]
    )
    return pose.apply(local)


@pytest.mark.parametrize(("cell", "share"), [(0.1, 0.02), (0.5, 0.15)])
def test_what_is_called_free_touches_neither_map_nor_scan(cell: float, share: float) -> None:
    rng = np.random.default_rng(2)
    ended = 0
    for _ in range(300):
        solid = rng.random((round(4.0 / cell), round(4.0 / cell))) < share
        grid = GridMap(solid, np.zeros_like(solid), cell, 0.0, 0.0)
        x, y = rng.uniform(1.0, 3.0, 2)
        pose = Pose2(x, y, rng.uniform(-3.0, 3.0))
        scan = rng.uniform(-1.5, 1.5, (rng.integers(0, 6), 2))
        curvature, length = rng.uniform(-4.0, 4.0), rng.uniform(-0.8, 0.8)
        free, held = WayGuard(NEEDED, grid).free_way(pose, scan, curvature, length)
        ended += held is not None
        assert (held is None) == (free == length)
        points, seen = swept(pose, curvature, free), pose.apply(scan)
        on_map = Clearances(grid).at(points)
        least = min(NEEDED, Clearances(grid).nearest(pose[:2]).distance)
        assert (on_map >= least - 0.002).all()
        for x, y in seen.tolist():
            away = np.hypot(points[:, 0] - x, points[:, 1] - y)
            near = np.hypot(*(seen - pose[:2]).T).min()
            assert (away >= min(NEEDED, near) - 0.002).all()
    assert 50 < ended < 250


def test_an_arc_ends_before_what_the_map_shows() -> None:
    free, held = WayGuard(NEEDED, WALL).free_way(Pose2(3.0, 2.0, 0.0), NO_STANDS, 0.0, 2.0)
    assert free == pytest.approx(0.6, abs=0.01)
    assert held is not None
    assert held.shown_by == "map"
    assert held.x == pytest.approx(3.9)
    assert held.y == pytest.approx(2.0, abs=1e-3)


def test_what_is_too_near_may_be_left_and_not_be_come_nearer_to() -> None:
    guard, here = WayGuard(NEEDED, WALL), Pose2(3.75, 2.0, 0.0)
    assert guard.free_way(here, NO_STANDS, 0.0, -0.5) == (-0.5, None)
    assert guard.free_way(here, NO_STANDS, 0.0, 0.05)[1] is not None
    assert guard.free_way(here._replace(theta=math.pi / 2), NO_STANDS, 0.0, 0.5)[1] is not None  # along it


def test_where_it_stood_too_near_it_may_come_back_to_and_no_nearer() -> None:
    guard = WayGuard(NEEDED, WALL)
    guard.stand_at(Pose2(3.75, 2.0, 0.0), NO_STANDS)
    out = Pose2(3.4, 2.0, 0.0)
    assert guard.free_way(out, NO_STANDS, 0.0, 0.35) == (0.35, None)
    assert guard.free_way(out, NO_STANDS, 0.0, 0.38)[1] is not None
    assert guard.free_way(Pose2(3.4, 3.0, 0.0), NO_STANDS, 0.0, 0.35)[1] is not None  # another place


def test_declared_place_excuses_the_map_but_not_the_scan() -> None:
    guard, out = WayGuard(NEEDED, WALL), Pose2(3.4, 2.0, 0.0)
    guard.may_stand_at(Pose2(3.65, 2.0, 0.0))
    assert guard.free_way(out, NO_STANDS, 0.0, 0.25) == (0.25, None)
    free, held = guard.free_way(out, np.array([[0.52, 0.0]]), 0.0, 0.25)
    assert free == pytest.approx(0.22, abs=0.01)
    assert held is not None
    assert held.shown_by == "scan"
    assert held.x == pytest.approx(3.92)
    assert held.y == pytest.approx(2.0)
