"""Surfaces that a scan shows: smoothed points with normals, ready for matching point to line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

HALF_WINDOW = 8
"""Beams on each side of a beam that may belong to the same surface."""
MIN_SUPPORT_M = 0.2
"""Points within this distance belong to the same surface."""
SPACING_SUPPORT = 3.5
"""Minimum support in distances between neighbouring beams, if that is more than `MIN_SUPPORT_M`."""
MIN_LINE_POINTS = 4
MAX_FLATNESS = 0.1
"""Largest ratio of a surface's thickness to its length; more is a corner or a bush."""


class Surface:
    """Points on flat surfaces in a lidar scan, each with the surface's normal towards the side that was
    seen.
    """

    def __init__(self, points: FloatArray, normals: FloatArray) -> None:
        """Store points and normals.

        Args:
            points: (n, 2) in any one frame, in [m].
            normals: (n, 2) unit vectors in the same frame.
        """
        self.points, self.normals = points, normals

    @cached_property
    def tree(self) -> Any:
        """Nearest-neighbour index of the surface's points."""
        from scipy.spatial import cKDTree

        return cKDTree(self.points)

    def moved(self, pose: Pose2) -> Surface:
        """Transform the surface from the frame of `pose` into the frame in which `pose` is given."""
        return Surface(pose.apply(self.points), Pose2(0.0, 0.0, pose.theta).apply(self.normals))

    def thinned(self, most: int) -> Surface:
        """Return a surface with every k-th point of this one, so that at most `most` points are left."""
        stride = max(1, math.ceil(len(self.points) / most))
        return Surface(self.points[::stride], self.normals[::stride])


def merge_surfaces(surfaces: Sequence[Surface]) -> Surface:
    """Return one surface with the points of all given surfaces."""
    return Surface(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
    )


def fit_surface(points: FloatArray, origin: FloatArray) -> Surface:
    """Fit a line through the neighbours of each point of a scan, and return the points on flat surfaces.

    Each point is moved onto its line, so that the noise of a single beam averages out.

    Args:
        points: (n, 2) where beams ended, in any one frame, in the order of their angles, in [m].
        origin: (2,) position of the sensor in the same frame, in [m].
    """
    if len(points) < MIN_LINE_POINTS:
        return Surface(np.empty((0, 2)), np.empty((0, 2)))
    near, weights = _neighbours(points, origin)
    counts = weights.sum(axis=1)
    means = (near * weights[..., None]).sum(axis=1) / counts[:, None]
    off = (near - means[:, None]) * weights[..., None]
    xx, xy, yy = (off[..., i] * off[..., j] for i, j in ((0, 0), (0, 1), (1, 1)))
    xx, xy, yy = xx.sum(axis=1), xy.sum(axis=1), yy.sum(axis=1)
    spread = np.hypot(0.5 * (xx - yy), xy)
    thin, long = np.maximum(0.5 * (xx + yy) - spread, 0.0), 0.5 * (xx + yy) + spread
    direction = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    normals = np.stack([-np.sin(direction), np.cos(direction)], axis=1)
    normals[((origin - points) * normals).sum(axis=1) < 0.0] *= -1.0
    flat = (counts >= MIN_LINE_POINTS) & (np.sqrt(thin) < MAX_FLATNESS * np.sqrt(long))
    above = ((points - means) * normals).sum(axis=1)
    smooth = points - above[:, None] * normals
    return Surface(smooth[flat], normals[flat])


def _neighbours(points: FloatArray, origin: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the points (n, k, 2) around each point, and weights (n, k): 1 on the same surface, otherwise
    0.
    """
    count = len(points)
    offsets = np.arange(-HALF_WINDOW, HALF_WINDOW + 1)
    index = (np.arange(count)[:, None] + offsets) % count
    near = points[index]
    distances = np.linalg.norm(near - points[:, None], axis=2)
    ranges = np.linalg.norm(points - origin, axis=1)
    reach = np.maximum(MIN_SUPPORT_M, SPACING_SUPPORT * _spacing(points, ranges))
    return near, (distances <= reach[:, None]).astype(np.float64)


def _spacing(points: FloatArray, ranges: FloatArray) -> FloatArray:
    """Return the distance (n,) in [m] to the nearer neighbour in a scan, within what two degrees allow."""
    step = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    nearer = np.minimum(step, np.roll(step, -1))
    limited: FloatArray = np.minimum(nearer, ranges * math.radians(2.0))
    return limited
