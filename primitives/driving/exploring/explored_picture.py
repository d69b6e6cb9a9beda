"""Picture of an explored map: cells, trajectory, and what is left of the border."""

from __future__ import annotations

import cv2
import numpy as np

from handcart.robotics.navigation.exploring.frontiers import Border
from handcart.robotics.navigation.mapping.map_building import BuiltMap
from handcart.robotics.navigation.maps.grid_map import UNKNOWN_GREY, GridMap
from handcart.robotics.numerics.arrays import ByteArray, FloatArray, IntArray

MIN_WIDTH_PX = 800
BLUE, GREEN, RED = (178, 114, 0), (115, 158, 0), (0, 94, 213)  # BGR of Okabe and Ito (2008)


def explored_picture(grid: GridMap, built: BuiltMap, border: Border | None) -> ByteArray:
    """Return a picture (h, w, 3) of a map in BGR, with trajectory, loop closures and remaining frontiers.

    The trajectory is blue, loop closures are green, and frontiers red.

    Args:
        grid: the map.
        built: keyframes and loop closures of the map.
        border: border of the known ground; None: no frontiers are drawn.
    """
    scale = max(1, round(MIN_WIDTH_PX / max(grid.occupied.shape)))
    grey = np.where(grid.occupied, 0, np.where(grid.unknown, UNKNOWN_GREY, 255)).astype(np.uint8)
    large = cv2.resize(grey[::-1], None, fx=scale, fy=scale, interpolation=cv2.INTER_NEAREST)
    picture = np.asarray(cv2.cvtColor(large, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    for loop in built.accepted:
        ends = _pixels(grid, built.poses[[loop.first, loop.second], :2], scale)
        cv2.line(picture, ends[0].tolist(), ends[1].tolist(), GREEN, 1, cv2.LINE_AA)
    cv2.polylines(picture, [_pixels(grid, built.poses[:, :2], scale)], False, BLUE, 2, cv2.LINE_AA)
    cv2.circle(picture, _pixels(grid, built.poses[:1, :2], scale)[0].tolist(), 6, BLUE, cv2.FILLED)
    for frontier in () if border is None else border.frontiers:
        for x, y in _pixels(grid, frontier.cells, scale).tolist():
            cv2.circle(picture, (x, y), scale, RED, cv2.FILLED)
    return picture


def _pixels(grid: GridMap, points: FloatArray, scale: int) -> IntArray:
    """Return the pixels (n, 2) of points (n, 2) on the map, in [m]."""
    height = len(grid.occupied)
    x, y = ((points - (grid.origin_x, grid.origin_y)) / grid.resolution).T
    return np.asarray(np.column_stack([x, height - y]) * scale, dtype=np.int32)
