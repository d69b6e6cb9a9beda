"""Area that a polygon may sweep, compared with exact motion in small steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.footprint import polygon
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.footprint_guard import (
    LEAST_ROOM_M,
    MIN_STEP_M,
    FootprintGuard,
    SensorView,
)
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray

SHAPE = polygon(np.array([[0.3, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.3, -0.2]]))
ORIGIN, MARGIN, NOTHING = Pose2(0.0, 0.0, 0.0), 0.008, np.empty((0, 2))
ALL_ROUND = SensorView(0.0, 0.0, -math.pi, 2.0 * math.pi)


def swept_room(point: FloatArray, length: float, turn: float) -> float:
    """Least distance of a point to the polygon along an arc, by a thousand steps."""
    angle = np.linspace(0.0, turn, 1000)
    x, y = length / turn * np.sin(angle), length / turn * (1.0 - np.cos(angle))
    ahead, left = point[0] - x, point[1] - y
    local = [np.cos(angle) * ahead + np.sin(angle) * left, np.cos(angle) * left - np.sin(angle) * ahead]
    return float(SHAPE.distances(np.column_stack(local)).min())


def test_free_motion_agrees_with_small_steps() -> None:
    rng, guard, hits = np.random.default_rng(3), FootprintGuard(SHAPE, MARGIN), 0
    for _ in range(150):
        point, length, turn = rng.uniform(-0.7, 0.7, 2), rng.uniform(-0.5, 0.5), rng.uniform(-1.0, 1.0)
        if SHAPE.distances(point[None])[0] < MARGIN:
            continue
        least = swept_room(point, length, turn)
        held = guard.free_motion(ORIGIN, point[None], length, turn)
        if abs(least - MARGIN) > MIN_STEP_M:
            assert (held is not None) == (least < MARGIN)
            hits += held is not None
    assert hits > 10


def test_turn_in_place_sweeps_the_corners() -> None:
    guard, beside = FootprintGuard(SHAPE, MARGIN), np.array([[0.15, 0.25]])
    held = guard.free_motion(ORIGIN, beside, 0.0, 0.4)
    assert held is not None
    assert held.shown_by == "scan"
    assert (held.x, held.y) == (0.15, 0.25)
    assert guard.free_motion(ORIGIN, np.array([[0.0, 0.37]]), 0.0, 2.0) is None


def test_too_near_to_a_wall_it_may_drive_along_but_not_closer() -> None:
    wall = np.column_stack([np.linspace(-2.0, 2.0, 400), np.full(400, 0.204)])
    guard = FootprintGuard(SHAPE, MARGIN)
    assert guard.free_motion(ORIGIN, wall, 0.4, 0.0) is None
    assert guard.free_motion(ORIGIN, wall, -0.4, 0.0) is None
    assert guard.free_motion(ORIGIN, wall, 0.2, 0.1) is not None
    assert guard.free_motion(ORIGIN, np.array([[0.3 + 0.5 * LEAST_ROOM_M, 0.0]]), 0.05, 0.0) is not None


def test_it_may_return_to_where_it_stood() -> None:
    ahead = np.array([[0.29, 0.0]])  # it is 1 cm within the sensed obstacle
    guard = FootprintGuard(SHAPE, MARGIN)
    guard.stand_at(ORIGIN, ahead)
    back = Pose2(-0.1, 0.0, 0.0)
    assert guard.free_motion(back, back.inverse().apply(ahead), 0.1, 0.0) is None
    guard.stand_at(back, back.inverse().apply(ahead))
    assert guard.free_motion(back, back.inverse().apply(ahead), 0.1, 0.0) is not None


def test_cells_of_the_map_count_as_squares_where_no_beam_goes() -> None:
    occupied = np.zeros((40, 40), dtype=np.bool_)
    occupied[:, 27] = True  # from x = 0.35 m on, its centres at 0.375 m
    grid = GridMap(occupied, np.zeros_like(occupied), 0.05, -1.0, -1.0)
    guard = FootprintGuard(SHAPE, MARGIN, grid)
    assert guard.free_motion(ORIGIN, NOTHING, 0.06, 0.0, ALL_ROUND) is None
    held = guard.free_motion(ORIGIN, NOTHING, 0.06, 0.0, None)
    assert held is not None
    assert held.shown_by == "map"
    behind = SensorView(0.0, 0.0, 0.5 * math.pi, math.pi)
    assert guard.free_motion(ORIGIN, NOTHING, 0.06, 0.0, behind) is not None


@pytest.mark.parametrize("turn", [0.0, 1e-9, -1e-9])
def test_straight_motion_has_no_special_turn(turn: float) -> None:
    guard = FootprintGuard(SHAPE, MARGIN)
    assert guard.free_motion(ORIGIN, np.array([[0.5, 0.19]]), 0.18, turn) is None
    assert guard.free_motion(ORIGIN, np.array([[0.5, 0.19]]), 0.2, turn) is not None


def test_scan_counts_alone_where_it_shows_what_the_map_shows() -> None:
    """A door is 2 cm off its place on the map, because the pose is."""
    occupied = np.zeros((40, 40), dtype=np.bool_)
    occupied[23:, 27] = True  # y from 0.15 m on, centres from 0.175 m on, at x = 0.375 m
    guard = FootprintGuard(SHAPE, MARGIN, GridMap(occupied, np.zeros_like(occupied), 0.05, -1.0, -1.0))
    wall = np.column_stack([np.full(40, 0.36), np.linspace(0.215, 0.8, 40)])
    assert guard.free_motion(ORIGIN, wall, 0.3, 0.0, ALL_ROUND) is None
    held = guard.free_motion(ORIGIN, NOTHING, 0.3, 0.0, ALL_ROUND)  # glass: no beam comes back
    assert held is not None
    assert held.shown_by == "map"
