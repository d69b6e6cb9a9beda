"""The rolling occupancy of what no map shows."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.maps.scan_layer import ScanLayer

ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)
SENSOR = Pose2(2.0, 2.0, 0.3)


@pytest.fixture
def grid() -> GridMap:
    """4 x 4 m without anything."""
    return from_boxes([], 0.05, (0.0, 0.0), (4.0, 4.0))


def take(layer: ScanLayer, times: int, distance: float, explained: bool = False) -> None:
    """Take in a round wall about the sensor, or with infinity nothing."""
    ranges = np.full(len(ANGLES), distance)
    for number in range(times):
        layer.take(SENSOR, ANGLES, ranges, np.full(len(ANGLES), explained), float(number))


def test_two_hits_occupy_and_beams_that_pass_clear(grid: GridMap) -> None:
    layer = ScanLayer(grid)
    take(layer, 1, 1.0)
    assert not layer.occupied.any()  # a lone reading may be noise
    take(layer, 5, 1.0)
    away = np.hypot(*(layer.points - SENSOR[:2]).T)
    assert len(away) > 100
    assert np.all(np.abs(away - 1.0) < 0.06)
    take(layer, 12, np.inf)
    assert not layer.occupied.any()


def test_hits_at_walls_of_the_map_raise_nothing(grid: GridMap) -> None:
    layer = ScanLayer(grid)
    take(layer, 5, 1.0, explained=True)
    assert not layer.occupied.any()


def test_unknown_beams_clear_nothing(grid: GridMap) -> None:
    layer = ScanLayer(grid)
    take(layer, 5, 1.0)
    before = layer.occupied.copy()
    take(layer, 20, np.nan)
    assert np.array_equal(layer.occupied, before)


def test_cells_beside_a_hit_are_not_cleared_by_the_same_scan(grid: GridMap) -> None:
    """A corner that fills little of its cell is passed by more beams than hit it."""
    layer = ScanLayer(grid)
    layer.add(np.array([[3.0, 2.0]]), 0.0)
    angles = np.array([0.0, 0.03]) - SENSOR.theta
    for _ in range(30):  # one beam passes through the cell, the other ends in the one beside it
        layer.take(SENSOR, angles, np.array([3.0, 1.01]), np.zeros(2, dtype=np.bool_), 1.0)
    assert layer.occupied[tuple(grid.to_cell(np.array([[3.0, 2.0]]))[0])]


def test_cells_survive_a_state_and_old_ones_are_forgotten(grid: GridMap) -> None:
    layer = ScanLayer(grid)
    take(layer, 5, 1.0)
    layer.add(np.array([[0.5, 0.5], [9.0, 9.0]]), 50.0)  # the second one is beyond the map
    other = ScanLayer(grid)
    other.restore(layer.cells())
    assert np.array_equal(other.occupied, layer.occupied)
    assert np.array_equal(layer.merged().occupied, layer.occupied)
    assert other.forget(before=40.0)
    assert other.points.tolist() == [[0.525, 0.525]]
