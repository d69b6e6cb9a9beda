"""Discs that hold what a range sensor saw."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

MAX_POINT_GAP_M = 0.6  # [m]: points nearer to each other belong to one thing
HIDDEN_DEPTH_M = 0.25  # [m] by which a thing may be deeper than it was seen


def point_discs(points: FloatArray) -> FloatArray:
    """Return discs (n, 3), x, y and radius in [m], that cover the obstacles on which points lie.

    Points connected by gaps of at most `MAX_POINT_GAP_M` lie on the same obstacle. Its disc contains these
    points and reaches `HIDDEN_DEPTH_M` beyond them, because an obstacle may be deeper than it was seen.

    Args:
        points: (m, 2) in any one frame, in [m].
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    if len(points) == 0:
        return np.empty((0, 3))
    # Late: every task imports this module, and few robots see what isn't on their map.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(MAX_POINT_GAP_M, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points),) * 2)
    count, label = connected_components(links, directed=False)
    return np.array([_disc(points[label == k]) for k in range(count)])


def _disc(points: FloatArray) -> FloatArray:
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = float(np.hypot(*(points - middle).T).max()) + HIDDEN_DEPTH_M
    return np.array([*middle, radius])
