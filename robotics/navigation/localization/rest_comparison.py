"""How well two scans of a base at rest agree, whatever the map shows."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from handcart.robotics.numerics.arrays import FloatArray

AGREEMENT_SCALE_M = 0.03  # of the distances that count half
SURFACE_GAP_M = 0.3  # between neighbouring points that are on one surface, at most


def disagreement(then: FloatArray, now: FloatArray) -> float:
    """Return the mean robust distance of points to the surfaces of an earlier scan, 0 to 1.

    Distances to the lines between neighbouring points of the earlier scan are weighed as by Geman and
    McClure, so that what has come since counts 1, however far away it is.

    Args:
        then: (n, 2) points of the earlier scan, in the order of their beams, in [m].
        now: (m, 2) points in the same frame, in [m].
    """
    if len(then) < 2 or not len(now):
        return 1.0
    away, nearest = cKDTree(then).query(now)
    for beside in (-1, 1):
        away = np.minimum(away, _to_segment(now, then[nearest], np.roll(then, -beside, axis=0)[nearest]))
    squared = away**2
    return float(np.mean(squared / (squared + AGREEMENT_SCALE_M**2)))


def _to_segment(points: FloatArray, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the distances (m,) of points (m, 2) to segments; infinite to those across a gap."""
    rays = ends - starts
    squared = np.maximum((rays**2).sum(axis=1), 1e-12)
    share = np.clip(((points - starts) * rays).sum(axis=1) / squared, 0.0, 1.0)
    away = np.hypot(*(points - starts - share[:, None] * rays).T)
    return np.asarray(np.where(squared <= SURFACE_GAP_M**2, away, np.inf))
