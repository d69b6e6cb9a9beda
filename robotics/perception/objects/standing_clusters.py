"""Groups of points above a level surface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from scipy.spatial import cKDTree

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .depth_view import OverSurface

MIN_HEIGHT_M = 0.012  # over the surface
MAX_HEIGHT_M = 0.5
CELL_M = 0.004  # of the grid in which points are joined
MIN_POINTS = 60
TOP_BAND_M = 0.008  # below the highest points
LEVEL_BAND_M = 0.004  # around their median; of a side that is seen too, little is within
TOP_PERCENTILE = 98.0
MIN_OUTLINE_CELL_M = 0.002
CELL_SPACINGS = 1.3  # of an outline's grid, in distances of neighbouring points
BORDER_CELLS = 2.5  # from a point at the picture's edge within which an outline isn't true


class PointCluster(NamedTuple):
    """Points of one thing on a surface, in the frame of the surface: x and y along its sides, z upwards."""

    points: FloatArray
    """(n, 3) in [m]."""
    top: float
    """Height of its upper side, in [m]."""
    outline: FloatArray
    """(k, 2) points around its upper side, without those at the edge of a picture, in [m]."""
    cell: float
    """Distance of neighbouring points of the outline, in [m]."""
    pixel: float
    """Distance of neighbouring points of the upper side, in [m]."""
    eye: FloatArray
    """(3,) mean place of the cameras, in [m]."""


def standing_clusters(views: Sequence[OverSurface], size: tuple[float, float]) -> list[PointCluster]:
    """Return groups of points, each of one thing on a surface, from all views together, the largest first.

    Args:
        views: points of each view, in the frame of the surface.
        size: size of the surface along x and y, in [m].
    """
    if not views:
        return []
    points = np.vstack([view.points for view in views])
    border = np.concatenate([view.at_border for view in views])
    numbers = np.repeat(np.arange(len(views)), [len(view.points) for view in views])
    inside = (np.abs(points[:, :2]) < np.array(size) / 2 + MIN_HEIGHT_M).all(axis=1)
    inside &= (points[:, 2] > MIN_HEIGHT_M) & (points[:, 2] < MAX_HEIGHT_M)
    points, border, numbers = points[inside], border[inside], numbers[inside]
    if len(points) < MIN_POINTS:
        return []
    labels = _labels(points)
    found = []
    for label in np.unique(labels):
        chosen = labels == label
        if chosen.sum() >= MIN_POINTS:
            seen_from = [views[number] for number in np.unique(numbers[chosen])]
            cluster = _cluster(points[chosen], border[chosen], seen_from)
            if cluster is not None:
                found.append(cluster)
    return sorted(found, key=lambda item: -len(item.points))


def _labels(points: FloatArray) -> FloatArray:
    """Return (n,) numbers of the connected patches of the floor that points (n, 3) are over."""
    low = points[:, :2].min(axis=0) - 2 * CELL_M
    cells = np.floor((points[:, :2] - low) / CELL_M).astype(np.int64)
    grid = np.zeros(cells.max(axis=0) + 3, np.uint8)
    grid[cells[:, 0], cells[:, 1]] = 1
    closed = cv2.morphologyEx(grid, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    _, labels = cv2.connectedComponents(closed, connectivity=8)
    return np.asarray(labels[cells[:, 0], cells[:, 1]], dtype=np.float64)


def _cluster(points: FloatArray, border: BoolArray, views: Sequence[OverSurface]) -> PointCluster | None:
    highest = float(np.percentile(points[:, 2], TOP_PERCENTILE))
    level = float(np.median(points[points[:, 2] > highest - TOP_BAND_M, 2]))
    upper = np.abs(points[:, 2] - level) < LEVEL_BAND_M
    top, eye = points[upper], np.mean([view.eye for view in views], axis=0)
    distance = max(float(np.linalg.norm(view.eye - top.mean(axis=0))) for view in views)
    pixel = max(view.spacing for view in views) * distance
    cell = max(MIN_OUTLINE_CELL_M, CELL_SPACINGS * pixel)
    outline = outline_of(top[:, :2], cell)
    if outline is None:
        return None
    cut = points[border]
    if len(cut):
        away = cKDTree(cut[:, :2]).query(outline)[0]
        outline = outline[away > BORDER_CELLS * cell]
    return PointCluster(points, float(np.median(top[:, 2])), outline, cell, pixel, eye)


def outline_of(points: FloatArray, cell: float) -> FloatArray | None:
    """Return the outline (k, 2) of the largest connected patch of points; None if there is no patch.

    Points are rounded to a grid, and neighbouring cells of the grid are connected. The outline has the frame
    and unit of the points.

    Args:
        points: (n, 2) in any one frame, in [m].
        cell: side of a cell of the grid, in [m].
    """
    low = points.min(axis=0) - 4 * cell
    cells = np.rint((points - low) / cell).astype(np.int64)
    grid = np.zeros(cells.max(axis=0) + 5, np.uint8)
    grid[cells[:, 0], cells[:, 1]] = 1
    closed = cv2.morphologyEx(grid, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(closed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    longest = max(contours, key=cv2.contourArea).reshape(-1, 2)[:, ::-1]
    return np.asarray(low + longest * cell)
