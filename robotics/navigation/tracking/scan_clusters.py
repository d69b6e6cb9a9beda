"""Clusters of a scan's points that may be a person or a cart."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from handcart.robotics.numerics.arrays import FloatArray, IntArray

BREAK_M = 0.13  # between neighbouring points of different bodies
PAIR_DISTANCE_M = 0.6  # between the outermost pieces of one body, such as two legs
MAX_EXTENT_M = 1.2  # of a person, a pram or a cart
MIN_POINTS = 2  # of a leg, with a beam a degree; a lone one is noise
DEPTH_SHARE = 0.32  # of a round body's width, from the mean of its visible points to its middle


class ScanClusters(NamedTuple):
    """Groups of scan points that have the size of a person or a cart."""

    centres: FloatArray
    """(k, 2) estimated middles, in the frame of the points, in [m]."""
    radii: FloatArray
    """(k,) from the middle to the outermost point, in [m]."""
    labels: IntArray
    """(n,) index of the body of each point; -1 for points of no such body."""


def cluster_scan(points: FloatArray, sensor: FloatArray) -> ScanClusters:
    """Group the points of a scan into bodies.

    Neighbouring points closer than `BREAK_M` are joined to pieces. Pieces are joined to a body if all their
    distances are below `PAIR_DISTANCE_M` (complete linkage). So two legs become one person, while two persons
    side by side stay separate.

    Args:
        points: (n, 2) points of the scan in the order of their beams, in any one frame, in [m].
        sensor: (2,) position of the lidar in the same frame, in [m].
    """
    labels = np.full(len(points), -1, dtype=np.int64)
    pieces, middles, widths = _pieces(points, sensor)
    if not len(middles):
        return ScanClusters(np.empty((0, 2)), np.empty(0), labels)
    bodies = _bodies(middles, widths)
    count = int(bodies.max()) + 1
    weights = np.bincount(bodies, minlength=count).astype(np.float64)
    centres = np.column_stack([np.bincount(bodies, middles[:, i], count) / weights for i in (0, 1)])
    outer = np.hypot(*(middles - centres[bodies]).T) + 0.5 * widths
    radii = np.zeros(count)
    np.maximum.at(radii, bodies, outer)
    kept = np.flatnonzero(2.0 * radii <= MAX_EXTENT_M)
    number = np.full(count, -1, dtype=np.int64)
    number[kept] = np.arange(len(kept))
    inside = pieces >= 0
    labels[inside] = number[bodies[pieces[inside]]]
    return ScanClusters(centres[kept], radii[kept], labels)


def _pieces(points: FloatArray, sensor: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the piece of each point (n,), -1 for lone ones, and middles (k, 2) and widths (k,) of pieces."""
    none = np.full(len(points), -1, dtype=np.int64)
    if not len(points):
        return none, np.empty((0, 2)), np.empty(0)
    steps = np.hypot(*np.diff(points, axis=0).T)
    pieces = np.concatenate([[0], np.cumsum(steps > BREAK_M)]).astype(np.int64)
    if len(points) > 2 and pieces[-1] > 0 and np.hypot(*(points[0] - points[-1])) <= BREAK_M:
        pieces[pieces == pieces[-1]] = 0
    count = int(pieces.max()) + 1
    sizes = np.bincount(pieces, minlength=count)
    means = np.column_stack([np.bincount(pieces, points[:, i], count) for i in (0, 1)])
    means = np.asarray(means / np.maximum(sizes, 1)[:, None])
    away = np.hypot(*(means - sensor).T)
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, pieces, points)
    np.maximum.at(high, pieces, points)
    widths = np.hypot(*(high - low).T)
    enough = (sizes >= MIN_POINTS) & (widths <= MAX_EXTENT_M)
    rays = (means - sensor) / np.maximum(away, 1e-9)[:, None]
    middles = means + DEPTH_SHARE * widths[:, None] * rays
    number = np.full(count, -1, dtype=np.int64)
    number[enough] = np.arange(int(enough.sum()))
    return number[pieces], middles[enough], widths[enough]


def _bodies(middles: FloatArray, widths: FloatArray) -> IntArray:
    """Return the body (k,) of each piece: small pieces near each other are one, large ones stay alone."""
    bodies = np.arange(len(middles))
    small = np.flatnonzero(widths < 0.5 * PAIR_DISTANCE_M)
    if len(small) > 1:
        groups = fcluster(linkage(middles[small], "complete"), PAIR_DISTANCE_M, "distance")
        bodies[small] = len(middles) + groups
    _, numbered = np.unique(bodies, return_inverse=True)
    return np.asarray(numbered, dtype=np.int64)
