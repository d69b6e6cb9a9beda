"""Removal of known boxes, such as a table of known height, from a map that shows them among the walls."""

from __future__ import annotations

import math
from collections.abc import Iterable

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap
from handcart.robotics.numerics.arrays import FloatArray

MIN_OUTLINE_SHARE = 0.6  # a piece that stands undrawn in a corner has walls along half of its outline


def without_drawn_boxes(grid: GridMap, boxes: Iterable[FloorBox]) -> GridMap:
    """Return a map on which the cells that show one of the boxes are free.

    A box is shown if most of its outline is occupied. Then all cells up to one cell outside of it are freed,
    because a drawn outline is that inexact. Of a box that is not shown, no cell is freed: cells at its sides
    are walls.

    Args:
        grid: the map.
        boxes: boxes in the map frame.
    """
    occupied = grid.occupied.copy()
    cells = np.argwhere(grid.occupied)
    for box in boxes:
        outside = _distance_outside(box, grid.to_point(cells)) / grid.resolution
        if _outline_share(grid, box) >= MIN_OUTLINE_SHARE:
            occupied[tuple(cells[outside <= 1.0].T)] = False
    return grid._replace(occupied=occupied)


def _distance_outside(box: FloorBox, points: FloatArray) -> FloatArray:
    """Return how far each point (n, 2) is outside of a box along its sides, negative inside, in [m]."""
    local = Pose2(box.x, box.y, box.yaw).inverse().apply(points)
    distances: FloatArray = np.max(np.abs(local) - 0.5 * np.array([box.length, box.width]), axis=1)
    return distances


def _outline_share(grid: GridMap, box: FloorBox) -> float:
    """Return the share of a box's outline that has an occupied cell at most one cell away."""
    points = grid.to_cell(_outline(box, grid.resolution))
    padded = np.pad(cv2.dilate(grid.occupied.astype(np.uint8), np.ones((3, 3), np.uint8)), 1)
    clipped = np.clip(points + 1, 0, np.array(padded.shape) - 1)  # points off the map are in the padding
    return float(np.mean(padded[clipped[:, 0], clipped[:, 1]]))


def _outline(box: FloorBox, step: float) -> FloatArray:
    """Return points (n, 2) along the four sides of a box, at most `step` apart."""
    sides = []
    for length, width, turn in ((box.length, box.width, 0.0), (box.width, box.length, math.pi / 2)):
        along = np.linspace(-0.5, 0.5, math.ceil(length / step) + 1) * length
        for sign in (-0.5, 0.5):
            line = np.column_stack([along, np.full_like(along, sign * width)])
            sides.append(Pose2(box.x, box.y, box.yaw + turn).apply(line))
    return np.vstack(sides)
