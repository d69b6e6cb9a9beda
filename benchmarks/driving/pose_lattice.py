"""Search whether a polygon has any route: a flood of (x, y, heading), independent of the measured planner."""

from __future__ import annotations

import math

import cv2
import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, IntArray
from handcart.robotics.numerics.compiled import compiled

HEADINGS = 32


def is_connected(
    grid: GridMap, shape: Footprint, start: tuple[float, float], goal: tuple[float, float], room: float
) -> bool:
    """Return whether a base that drives along its heading and turns in place can get from start to goal.

    Args:
        grid: fine map of everything.
        shape: polygon of the footprint.
        start: position in [m], at any heading.
        goal: likewise.
        room: beside the footprint, in [m].
    """
    free = np.array([_free(grid, shape, 2.0 * math.pi * k / HEADINGS, room) for k in range(HEADINGS)])
    ends = grid.to_cell(np.array([start, goal]))
    return bool(_flood(free, ends[0], ends[1]))


def _free(grid: GridMap, shape: Footprint, heading: float, room: float) -> BoolArray:
    """(h, w) cells at which the footprint with `room` touches nothing at a heading."""
    reach = math.ceil((shape.radius + room) / grid.resolution) + 1
    offsets = np.arange(-reach, reach + 1) * grid.resolution
    x, y = np.meshgrid(offsets, offsets)
    cos, sin = math.cos(heading), math.sin(heading)
    local = np.column_stack([(cos * x + sin * y).ravel(), (cos * y - sin * x).ravel()])
    covered = (shape.distances(local) <= room).reshape(x.shape)
    hit = cv2.filter2D(
        grid.blocked.astype(np.float32), -1, covered.astype(np.float32), borderType=cv2.BORDER_CONSTANT
    )
    return np.asarray(hit < 0.5)


@compiled
def _flood(free: BoolArray, start: IntArray, goal: IntArray) -> bool:
    count, height, width = free.shape
    reached = np.zeros(free.shape, dtype=np.bool_)
    stack = np.empty((free.size, 3), dtype=np.int32)
    last = 0
    for k in range(count):
        if free[k, start[0], start[1]]:
            reached[k, start[0], start[1]] = True
            stack[last, 0], stack[last, 1], stack[last, 2] = k, start[0], start[1]
            last += 1
    while last > 0:
        last -= 1
        k, row, column = stack[last, 0], stack[last, 1], stack[last, 2]
        if row == goal[0] and column == goal[1]:
            return True
        angle = 2.0 * math.pi * k / count
        for move in range(4):
            heading, r, c = k, row, column
            if move < 2:
                heading = (k + 2 * move - 1) % count
            else:
                step = 1.5 if move == 2 else -1.5
                r, c = (
                    row + int(np.round(step * math.sin(angle))),
                    column + int(np.round(step * math.cos(angle))),
                )
            if 0 <= r < height and 0 <= c < width and free[heading, r, c] and not reached[heading, r, c]:
                reached[heading, r, c] = True
                stack[last, 0], stack[last, 1], stack[last, 2] = heading, r, c
                last += 1
    return False
