"""Surfaces that a scan shows: smoothed points with normals, ready for matching point to line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.numerics.compiled import compiled, compiled_for

from .surface_pairs import SortedSurface

HALF_WINDOW = 8
"""Beams on each side of a beam that may belong to the same surface."""
MIN_SUPPORT_M = 0.2
"""Points within this distance belong to the same surface."""
SPACING_SUPPORT = 3.5
"""Minimum support in distances between neighbouring beams, if that is more than `MIN_SUPPORT_M`."""
MAX_SPACING_RAD = math.radians(2.0)
"""Largest angle between two beams that counts as distance between neighbours."""
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
        self.points, self.normals = np.ascontiguousarray(points), np.ascontiguousarray(normals)

    @cached_property
    def sorted(self) -> SortedSurface:
        """Points and normals, in the order of the points along the axis of their larger extent; that axis."""
        axis = int(np.argmax(np.ptp(self.points, axis=0)))
        order = np.argsort(self.points[:, axis], kind="stable")
        return self.points[order], self.normals[order], axis

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
    smooth, normals, flat = _smoothed(np.ascontiguousarray(points), np.ascontiguousarray(origin))
    return Surface(smooth[flat], normals[flat])


@compiled_for("(f8[:,::1], f8[::1])")
def _smoothed(points: FloatArray, origin: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the points on their lines (n, 2), the lines' normals (n, 2) towards `origin`, and whether each
    surface is flat (n,).
    """
    count = len(points)
    smooth, normals, flat = np.empty((count, 2)), np.empty((count, 2)), np.empty(count, dtype=np.bool_)
    for i in range(count):
        x, y = points[i, 0], points[i, 1]
        near, mean_x, mean_y, xx, xy, yy = _scatter(points, i, _support(points, origin, i))
        spread = math.hypot(0.5 * (xx - yy), xy)
        thin, long = max(0.5 * (xx + yy) - spread, 0.0), 0.5 * (xx + yy) + spread
        direction = 0.5 * math.atan2(2.0 * xy, xx - yy)
        along, up = -math.sin(direction), math.cos(direction)
        if (origin[0] - x) * along + (origin[1] - y) * up < 0.0:
            along, up = -along, -up
        above = (x - mean_x) * along + (y - mean_y) * up
        normals[i, 0], normals[i, 1] = along, up
        smooth[i, 0], smooth[i, 1] = x - above * along, y - above * up
        flat[i] = near >= MIN_LINE_POINTS and math.sqrt(thin) < MAX_FLATNESS * math.sqrt(long)
    return smooth, normals, flat


@compiled
def _scatter(points: FloatArray, at: int, support: float) -> tuple[int, float, float, float, float, float]:
    """Return the number of neighbours of a point within a distance, their mean, and their scatter about it.

    The mean is x, y in [m]; the scatter is the sums of squares of x, of products, and of squares of y.
    """
    count, near, sum_x, sum_y = len(points), 0, 0.0, 0.0
    chosen = np.empty(2 * HALF_WINDOW + 1, dtype=np.int64)
    for offset in range(-HALF_WINDOW, HALF_WINDOW + 1):
        other = (at + offset) % count
        if math.hypot(points[other, 0] - points[at, 0], points[other, 1] - points[at, 1]) <= support:
            chosen[near] = other
            near, sum_x, sum_y = near + 1, sum_x + points[other, 0], sum_y + points[other, 1]
    mean_x, mean_y = sum_x / near, sum_y / near
    xx, xy, yy = 0.0, 0.0, 0.0
    for other in chosen[:near]:
        off_x, off_y = points[other, 0] - mean_x, points[other, 1] - mean_y
        xx, xy, yy = xx + off_x * off_x, xy + off_x * off_y, yy + off_y * off_y
    return near, mean_x, mean_y, xx, xy, yy


@compiled
def _support(points: FloatArray, origin: FloatArray, at: int) -> float:
    """Return the distance in [m] within which points belong to the surface of a point.

    It follows the distance to the nearer neighbour in the scan, within what two degrees allow.
    """
    before, after = points[at - 1], points[(at + 1) % len(points)]
    x, y = points[at, 0], points[at, 1]
    nearer = min(math.hypot(x - before[0], y - before[1]), math.hypot(x - after[0], y - after[1]))
    spacing = min(nearer, math.hypot(x - origin[0], y - origin[1]) * MAX_SPACING_RAD)
    return max(MIN_SUPPORT_M, SPACING_SUPPORT * spacing)
