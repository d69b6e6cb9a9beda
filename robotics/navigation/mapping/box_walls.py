"""Comparison of a map with boxes whose place is known exactly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray

from .map_comparison import SAME_WALL_M, wall_points

SAMPLE_M = 0.05
"""Distance between the points of an outline, in [m]."""
Box = tuple[float, float, float, float, float]
"""x, y in [m], yaw in [rad], length, width in [m]."""


class BoxWalls(NamedTuple):
    """Errors of a map's walls, found by comparing the map with the true boxes of the simulated world."""

    cells: FloatArray
    """(n,) distance of each wall cell to the nearest surface of a box, in [m]."""
    missing: list[float]
    """Share of the visible outline of each box that the map lacks, 0 to 1; 0 if nothing of it is visible."""
    visible: list[float]
    """Length of each box's outline that is outside the other boxes and on known ground, in [m]."""


def surface_distances(points: FloatArray, boxes: Sequence[Box]) -> FloatArray:
    """Return the distance (n,) of points to the nearest surface of any box, in [m].

    Args:
        points: (n, 2) in the frame of the boxes, in [m].
        boxes: boxes, of which only the outlines seen from above count.
    """
    found = np.full(len(points), np.inf)
    for box in boxes:
        beyond = _beyond(points, box)
        outside = np.hypot(*np.maximum(beyond, 0.0).T)
        found = np.minimum(found, np.where(outside > 0.0, outside, -beyond.max(axis=1)))
    return found


def compare_with_boxes(grid: GridMap, boxes: Sequence[Box], map_T_boxes: Pose2) -> BoxWalls:
    """Return the errors of a map's walls, by comparison with the boxes that are truly in the mapped world.

    Args:
        grid: the map.
        boxes: solids of the mapped world, for example of a simulated one.
        map_T_boxes: pose of the boxes' frame on the map.
    """
    from scipy.spatial import cKDTree

    walls, free = wall_points(grid), grid.to_point(np.argwhere(~grid.occupied & ~grid.unknown))
    open_ground = cKDTree(free) if len(free) else None
    tree, missing, visible = cKDTree(walls) if len(walls) else None, list[float](), list[float]()
    for box in boxes:
        outline = _outline(box)
        for other in boxes:
            if other is not box:
                outline = outline[_beyond(outline, other).max(axis=1) > 1e-6]
        seen = map_T_boxes.apply(outline)
        if open_ground is None:
            seen = seen[:0]
        elif len(seen):
            seen = seen[open_ground.query(seen)[0] <= SAME_WALL_M]
        away = tree.query(seen)[0] if tree is not None and len(seen) else np.full(len(seen), np.inf)
        visible.append(SAMPLE_M * len(seen))
        missing.append(float(np.mean(away > SAME_WALL_M)) if len(seen) else 0.0)
    return BoxWalls(surface_distances(map_T_boxes.inverse().apply(walls), boxes), missing, visible)


def _beyond(points: FloatArray, box: Box) -> FloatArray:
    """Return how far (n, 2) points are beyond a box's sides, along its own x and y; negative inside."""
    local = Pose2(*box[:3]).inverse().apply(points)
    beyond: FloatArray = np.abs(local) - 0.5 * np.array(box[3:])
    return beyond


def _outline(box: Box) -> FloatArray:
    """Return points (n, 2) along the outline of a box."""
    length, width = box[3:]
    sides = list[FloatArray]()
    for sign in (-0.5, 0.5):
        xs = np.arange(SAMPLE_M / 2, length, SAMPLE_M) - length / 2
        ys = np.arange(SAMPLE_M / 2, width, SAMPLE_M) - width / 2
        sides.append(np.column_stack([xs, np.full(len(xs), sign * width)]))
        sides.append(np.column_stack([np.full(len(ys), sign * length), ys]))
    return Pose2(*box[:3]).apply(np.concatenate(sides))
