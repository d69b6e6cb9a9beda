"""Areas of a map whose contents may have moved since it was made: scans there say nothing of the pose."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

HEIGHT_MARGIN_M = 0.05  # above and below a thing, within which a lidar may meet it: floors and mounts tilt
SUBCELL_BITS = 8  # binary places of a cell in which outlines are drawn


class MovableArea(NamedTuple):
    """Outline of a thing that may have moved since the map was made, and how far from this outline it may be
    now.
    """

    outline: FloatArray
    """(n, 2) corners of a polygon on the map, in [m]."""
    margin: float
    """Distance around the outline within which the thing may be now, in [m]."""
    low: float = 0.0
    """Height above the floor at which the thing begins, in [m]."""
    high: float = math.inf
    """Height above the floor at which it ends, in [m]."""


def with_movable(grid: GridMap, areas: Iterable[MovableArea], height: float | None = None) -> GridMap:
    """Return a map in which the areas of things that may have moved are marked; earlier marks are replaced.

    Args:
        grid: the map.
        areas: outlines of the things, and how far they may have moved.
        height: height of the lidar's scans above the floor, in [m]; areas of things that the scans pass over
            or under are ignored (default: none is ignored).
    """
    met = [area for area in areas if height is None or _meets(area, height)]
    if not met:
        return grid._replace(movable=None)
    movable = np.zeros(grid.occupied.shape, dtype=np.bool_)
    for area in met:
        movable |= _near(grid, area)
    return grid._replace(movable=movable)


def _meets(area: MovableArea, height: float) -> bool:
    return area.low - HEIGHT_MARGIN_M <= height <= area.high + HEIGHT_MARGIN_M


def _near(grid: GridMap, area: MovableArea) -> BoolArray:
    """Return (h, w) the cells of which any part may be within an area's margin."""
    around = math.ceil(area.margin / grid.resolution) + 2  # cells: a thing beyond the map may reach into it
    rows, columns = grid.occupied.shape
    away = np.ones((rows + 2 * around, columns + 2 * around), dtype=np.uint8)
    corner = (grid.origin_x, grid.origin_y)
    drawn = ((area.outline - corner) / grid.resolution - 0.5 + around) * 2.0**SUBCELL_BITS
    corners = [np.rint(drawn).astype(np.int32)]
    cv2.fillPoly(away, corners, 0.0, shift=SUBCELL_BITS)
    cv2.polylines(away, corners, True, 0.0, shift=SUBCELL_BITS)
    if away.all():
        return np.zeros((rows, columns), dtype=np.bool_)
    cells = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    near = cells * grid.resolution <= area.margin + grid.resolution
    return np.asarray(near[around : around + rows, around : around + columns])
