"""Changes of a map: cut to a rectangle, turned, with zones drawn in."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.maps.grid_map import (
    FREE_VALUE,
    OCCUPIED_VALUE,
    UNKNOWN_VALUE,
    GridMap,
    from_occupancy,
)
from handcart.robotics.navigation.maps.turned_map import turned_occupancy
from handcart.robotics.numerics.arrays import FloatArray, IntArray

MARGIN_CELLS = 5
"""Unknown cells kept around what is known."""
MAX_WALL_POINTS = 20_000
STRAIGHTENING_STEPS_RAD = (math.radians(0.5), math.radians(0.1), math.radians(0.02))
"""Steps of three searches for the turn; the first one tries turns of up to an eighth of a full turn."""


class NothingLeft(ValueError):
    """Error: an edit would leave no cell of a map."""


def crop_to(grid: GridMap, low: tuple[float, float], high: tuple[float, float]) -> GridMap:
    """Return the part of a map between two corners; cells that a corner touches are kept.

    Args:
        grid: the map.
        low: least x and y on the map, in [m].
        high: greatest x and y on the map, in [m].

    Raises:
        NothingLeft: the rectangle lies outside the map, or is empty.
    """
    rows, columns = grid.occupied.shape
    first = grid.to_cell(np.array([low]) + 1e-9)[0].clip(0)
    last = (grid.to_cell(np.array([high]) - 1e-9)[0] + 1).clip(max=(rows, columns))
    if (last <= first).any():
        right, top = grid.origin_x + columns * grid.resolution, grid.origin_y + rows * grid.resolution
        words = f"x {grid.origin_x:g} to {right:g} m, y {grid.origin_y:g} to {top:g} m"
        raise NothingLeft(f"nothing of the map is left; it covers {words}")
    return _part(grid, first, last)


def crop_to_known(grid: GridMap) -> GridMap:
    """Return the smallest rectangle of a map that contains all known cells.

    Raises:
        NothingLeft: all cells are unknown.
    """
    known = np.argwhere(~grid.unknown)
    if not len(known):
        raise NothingLeft("no cell of the map is known")
    first = (known.min(axis=0) - MARGIN_CELLS).clip(0)
    last = (known.max(axis=0) + 1 + MARGIN_CELLS).clip(max=grid.occupied.shape)
    return _part(grid, first, last)


def _part(grid: GridMap, first: IntArray, last: IntArray) -> GridMap:
    cut = slice(int(first[0]), int(last[0])), slice(int(first[1]), int(last[1]))
    x, y = (grid.origin_x, grid.origin_y) + first[::-1] * grid.resolution
    return GridMap(grid.occupied[cut], grid.unknown[cut], grid.resolution, float(x), float(y))


def turn(grid: GridMap, angle: float) -> GridMap:
    """Return a map turned anticlockwise by an angle, in [rad], about the origin of its frame.

    The cells of the result are again along the axes.

    Raises:
        TooManyCells: the turned map would be too large.
    """
    values = np.where(grid.occupied, OCCUPIED_VALUE, np.where(grid.unknown, UNKNOWN_VALUE, FREE_VALUE))
    corner = Pose2(0.0, 0.0, angle).compose(Pose2(grid.origin_x, grid.origin_y, 0.0))
    turned = turned_occupancy(values.astype(np.int8), grid.resolution, corner)
    return from_occupancy(turned.values, grid.resolution, turned.origin)


def straightening_angle(grid: GridMap) -> float:
    """Return the smallest turn in [rad], anticlockwise positive, after which most walls lie along x and y.

    After this turn the occupied cells are in as few rows and columns as possible: the sum of the squared
    numbers of occupied cells, over all rows and columns, is largest.
    """
    points = grid.to_point(np.argwhere(grid.occupied))
    points = points[:: max(1, len(points) // MAX_WALL_POINTS)]
    best = 0.0
    for reach, step in zip((0.25 * math.pi, *STRAIGHTENING_STEPS_RAD), STRAIGHTENING_STEPS_RAD, strict=False):
        turns = best + np.arange(-round(reach / step), round(reach / step) + 1) * step
        best = float(max(turns, key=lambda turned: _crowding(points, turned, grid.resolution)))
    return wrap(best)


def _crowding(points: FloatArray, angle: float, width: float) -> float:
    """Return the sum of squared counts of points (n, 2) in rows and columns of a width, after a turn."""
    turned = Pose2(0.0, 0.0, angle).apply(points)
    return sum(
        float((np.bincount(np.floor((column - column.min()) / width).astype(int)) ** 2).sum())
        for column in turned.T
    )


def paint_zone(zones: GridMap, corners: Sequence[tuple[float, float]], is_barred: bool) -> GridMap:
    """Return a map of barred zones, where a robot must not drive, after adding or removing a polygon.

    Args:
        zones: map whose occupied cells are zones.
        corners: x and y on the map of the polygon's corners, in order, in [m].
        is_barred: True to add the polygon as a zone; False to remove the zones that it covers.
    """
    scaled = (np.array(corners) - (zones.origin_x, zones.origin_y)) / zones.resolution - 0.5
    picture = np.zeros(zones.occupied.shape, np.uint8)
    shift = 8
    fixed = np.round(scaled * (1 << shift)).astype(np.int32)
    cv2.fillPoly(picture, [fixed], 1, shift=shift)
    covered = picture.astype(bool)
    occupied = (zones.occupied | covered) if is_barred else (zones.occupied & ~covered)
    return zones._replace(occupied=occupied, unknown=zones.unknown & ~covered)
