"""Beams of a lidar that should return, according to the map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

from .grid_map import GridMap

CELLS_PER_STEP = 32
"""Cells by which beams are followed at a time."""


class ExpectedEchoes(NamedTuple):
    """Occupied cell of the map that each beam of a lidar at a given pose should meet first, with its
    range.
    """

    met: BoolArray
    """(n,) whether it meets an occupied cell of the map within reach."""
    cells: IntArray
    """Number (n,) of the first such cell in the map, by rows; -1 if the beam meets none."""
    ranges: FloatArray
    """Range (n,) of that cell, in [m], in steps of the side of a cell; infinity if the beam meets none."""


def expected_echoes(grid: GridMap, map_T_sensor: Pose2, angles: FloatArray, reach: float) -> ExpectedEchoes:
    """Return the first occupied cell of the map that each beam should meet, and its range.

    Args:
        grid: the map; beams pass through unknown cells, and end nowhere beyond the map.
        map_T_sensor: pose of the lidar.
        angles: (n,) angles of the beams in the sensor frame, in [rad].
        reach: range up to which the beams are followed, in [m].
    """
    along = np.arange(grid.resolution, reach, grid.resolution) / grid.resolution
    turned = angles + map_T_sensor.theta
    column = (map_T_sensor.x - grid.origin_x) / grid.resolution
    row = (map_T_sensor.y - grid.origin_y) / grid.resolution
    met, cells = np.zeros(len(angles), np.bool_), np.full(len(angles), -1, np.int64)
    ranges = np.full(len(angles), np.inf)
    for near in range(
        0, len(along), CELLS_PER_STEP
    ):  # most beams meet a wall near by, and are followed no farther
        left = np.flatnonzero(~met)
        steps = along[near : near + CELLS_PER_STEP, None]
        columns, rows = column + steps * np.cos(turned[left]), row + steps * np.sin(turned[left])
        occupied = _occupied(grid, rows, columns)
        ends = np.flatnonzero(occupied.any(axis=0))
        first = occupied[:, ends].argmax(axis=0)
        beams, width = left[ends], grid.occupied.shape[1]
        met[beams] = True
        cells[beams] = rows[first, ends].astype(np.int64) * width + columns[first, ends].astype(np.int64)
        ranges[beams] = steps[first, 0] * grid.resolution
    return ExpectedEchoes(met, cells, ranges)


def _occupied(grid: GridMap, rows: FloatArray, columns: FloatArray) -> BoolArray:
    """Return whether positions (n, m) in cells from the corner are in occupied cells; none beyond the map."""
    height, width = grid.occupied.shape
    inside: BoolArray = (rows >= 0.0) & (rows < height) & (columns >= 0.0) & (columns < width)
    inside[inside] = grid.occupied[rows[inside].astype(np.int64), columns[inside].astype(np.int64)]
    return inside
