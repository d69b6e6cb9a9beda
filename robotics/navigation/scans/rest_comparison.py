"""Comparison of two scans of a base at rest, independent of the map."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

UNCHANGED_M = 0.06  # by which the range of a beam may change that sees the same surface
MIN_FACING_COS = 0.3  # of the angle between a beam and its surface's normal; flatter beams say little
MAX_SHARE_SIGMA = 0.2  # of the share of a motion, above which too few beams count
AGREEMENT_SCALE_M = 0.03  # of the distances that count half
SURFACE_GAP_M = 0.3  # between neighbouring points that are on one surface, at most


def disagreement(then: FloatArray, now: FloatArray) -> float:
    """Return how much the points of a scan disagree with the surfaces of an earlier scan, from 0 to 1.

    It is the mean of the points' distances to lines between neighbouring points of the earlier scan, with the
    robust function of Geman and McClure. So a point on an object that came later counts at most 1, however
    far away it is.

    Args:
        then: (n, 2) points of the earlier scan, in any one frame, in the order of their beams, in [m].
        now: (m, 2) points in the same frame, in [m].
    """
    if len(then) < 2 or not len(now):
        return 1.0
    away, nearest = cKDTree(then).query(now)
    for beside in (-1, 1):
        away = np.minimum(away, _to_segment(now, then[nearest], np.roll(then, -beside, axis=0)[nearest]))
    squared = away**2
    return float(np.mean(squared / (squared + AGREEMENT_SCALE_M**2)))


def share_moved(
    then: FloatArray, now: FloatArray, sensor: FloatArray, rolled: Pose2, moved: Pose2, sigma: float
) -> float | None:
    """Return which share of a small assumed motion has taken place, by the ranges of the same beams.

    The share is about 0 without the motion, and about 1 with it; None if the beams' ranges depend on the
    motion too little to measure it, given `sigma`.

    Args:
        then: (n, 2) ends of the beams before the motion, in the base frame, in [m]; NaN without an echo.
        now: (n, 2) ends of the same beams after the motion, in the base frame, in [m].
        sensor: (2,) position of the lidar in the base frame, in [m].
        rolled: then_T_now of the base by its wheels, a small motion as well.
        moved: assumed motion in addition to `rolled`, in the present base frame.
        sigma: noise of a range, in [m].
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        still = _expected_ranges(then, sensor, rolled)
        expected = _expected_ranges(then, sensor, rolled.compose(moved)) - still
        change = np.hypot(*(now - sensor).T) - still
        kept = np.isfinite(expected) & (np.abs(change) < UNCHANGED_M)
    information = float((expected[kept] ** 2).sum())
    if information <= 2.0 * (sigma / MAX_SHARE_SIGMA) ** 2:
        return None
    return float((expected[kept] * change[kept]).sum()) / information


def _expected_ranges(then: FloatArray, sensor: FloatArray, motion: Pose2) -> FloatArray:
    """Return the ranges of all beams (n,) after a small motion then_T_now, in [m].

    NaN where a beam grazes a surface, or its neighbours meet other surfaces.
    """
    along = np.roll(then, -1, axis=0) - np.roll(then, 1, axis=0)
    lengths = np.hypot(*along.T)
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(lengths, 1e-9)[:, None]
    beams = (then - sensor) / np.hypot(*(then - sensor).T)[:, None]
    here = motion.apply(sensor[None])[0]
    facing = (normals * (motion.apply(sensor + beams) - here)).sum(axis=1)
    ranges = (normals * (then - here)).sum(axis=1) / facing
    return np.asarray(np.where((np.abs(facing) > MIN_FACING_COS) & (lengths < SURFACE_GAP_M), ranges, np.nan))


def _to_segment(points: FloatArray, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the distances (m,) of points (m, 2) to segments; infinite to those across a gap."""
    rays = ends - starts
    squared = np.maximum((rays**2).sum(axis=1), 1e-12)
    share = np.clip(((points - starts) * rays).sum(axis=1) / squared, 0.0, 1.0)
    away = np.hypot(*(points - starts - share[:, None] * rays).T)
    return np.asarray(np.where(squared <= SURFACE_GAP_M**2, away, np.inf))
