"""An occupancy grid that is turned in its frame, resampled along the frame's axes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray, Int8Array

MAX_CELLS = 50_000_000
UNKNOWN_VALUE = -1
ROUNDING_CELLS = 1e-6  # of a cell


class TooManyCells(ValueError):
    """Error of a turned grid that would have too many cells."""


class TurnedOccupancy(NamedTuple):
    """Occupancy grid with cells along the axes of its frame, computed from a grid turned in this frame."""

    values: Int8Array
    """(h, w) in percent, -1 for unknown, row 0 at the bottom."""
    origin: tuple[float, float]
    """Lower-left corner, in [m]."""


def is_level(shape: tuple[int, ...], yaw: float) -> bool:
    """Return whether a turn by `yaw`, in [rad], is so small that all cells of a grid (h, w) move by less than
    half a cell.
    """
    return math.hypot(*shape) * abs(wrap(yaw)) < 0.5


def turned_occupancy(values: Int8Array, resolution: float, corner: Pose2) -> TurnedOccupancy:
    """Return a turned grid resampled to cells along x and y of the frame, each with the value of the nearest
    cell.

    No mean of cells is taken, so surfaces are not blurred, and are off by at most half a cell. New cells
    outside the turned grid are unknown.

    Args:
        values: (h, w) in percent, row 0 at the bottom of the turned grid.
        resolution: side of a cell, in [m].
        corner: pose of the turned grid's lower-left corner in the frame.

    Raises:
        TooManyCells: the new grid has more than 50 million cells.
    """
    height, width = values.shape
    reach = resolution * np.array([[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]])
    corners = corner.apply(reach)
    low = np.floor((corners.min(axis=0) - [corner.x, corner.y]) / resolution + ROUNDING_CELLS)
    high = np.ceil((corners.max(axis=0) - [corner.x, corner.y]) / resolution - ROUNDING_CELLS)
    columns, rows = (high - low).astype(int).tolist()
    if rows * columns > MAX_CELLS:
        raise TooManyCells(f"turned, the map has {columns} x {rows} cells; allowed: {MAX_CELLS} in all")
    origin = np.array([corner.x, corner.y]) + low * resolution
    sampled = np.full((rows, columns), UNKNOWN_VALUE, dtype=np.int8)
    for row in range(rows):  # a large map needs no coordinates of all its cells at once
        start = origin + np.array([0.0, row * resolution])
        _sample_row(values, resolution, corner, start, sampled[row])
    return TurnedOccupancy(sampled, (float(origin[0]), float(origin[1])))


def _sample_row(
    values: Int8Array,
    resolution: float,
    corner: Pose2,
    start: FloatArray,
    out: Int8Array,
) -> None:
    """Fill a row of new cells whose lower-left corner is at `start`."""
    height, width = values.shape
    cos, sin = math.cos(corner.theta), math.sin(corner.theta)
    x = start[0] + (np.arange(len(out)) + 0.5) * resolution - corner.x
    y = start[1] + 0.5 * resolution - corner.y
    column = np.floor((cos * x + sin * y) / resolution).astype(int)
    row = np.floor((cos * y - sin * x) / resolution).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    out[inside] = values[row[inside], column[inside]]
