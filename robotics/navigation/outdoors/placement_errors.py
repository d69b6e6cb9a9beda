"""Figures of merit of many placements: as the field test had them, and as they should be had."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2

TARGET_OFFSET_M = 0.75  # [m] from the base to the target on its right
MIN_PLACEMENTS = {0.95: 59, 0.997: 998}  # placements below which a share isn't claimed, with 95 % confidence
Array = NDArray[np.float64]


class Radius(NamedTuple):
    """Within which a share of the placements lies."""

    share: float
    radius: float
    """Radius in [m]."""
    low: float
    high: float
    """95 % of what other runs would have given, drawn by run, in [m]."""
    placements: int


def tip_place(pose: Pose2) -> Array:
    """(2,) where a sensor is laid from this base, in [m]."""
    return pose.apply(np.array([[0.0, -TARGET_OFFSET_M]])).reshape(2)


def tip_covariance(covariance: Array, heading: float) -> Array:
    """(2, 2) of `tip_place` in [m²] by the covariance (3, 3) of the base's pose."""
    by_pose = np.array(
        [[1.0, 0.0, TARGET_OFFSET_M * math.cos(heading)], [0.0, 1.0, TARGET_OFFSET_M * math.sin(heading)]]
    )
    spread: Array = by_pose @ covariance @ by_pose.T
    return spread


def aligned_spread(errors: Array, targets: Array) -> Array:
    """Return the standard deviations (2,) in x and y of errors (n, 2) of targets (n, 2), in [m].

    Defined as by Ohki et al. (2012): axes turned so that the first and the last deployed point lie in the
    direction of their targets, errors relative to their mean. So they are precision, not accuracy.
    """
    laid = targets + errors
    (ax, ay), (bx, by) = laid[-1] - laid[0], targets[-1] - targets[0]
    turn = math.atan2(by, bx) - math.atan2(ay, ax)
    cos, sin = math.cos(turn), math.sin(turn)
    away: Array = laid @ np.array([[cos, sin], [-sin, cos]]) - targets
    return np.asarray(away.std(axis=0, ddof=1))


def share_radius(errors: list[Array], share: float, seed: int = 0, draws: int = 1000) -> Radius | None:
    """Return the radius that holds a share of all placements; None if there are too few.

    `errors` (k, 2) in [m] of each run. Placements of one run depend on each other, so complete runs are
    drawn.
    """
    lengths = [np.hypot(*run.T) for run in errors]
    count = sum(map(len, lengths))
    if count < MIN_PLACEMENTS[share]:
        return None
    rng = np.random.default_rng(seed)
    drawn = [
        np.quantile(np.concatenate([lengths[k] for k in rng.integers(0, len(lengths), len(lengths))]), share)
        for _ in range(draws)
    ]
    low, high = np.percentile(drawn, [2.5, 97.5])
    return Radius(share, float(np.quantile(np.concatenate(lengths), share)), float(low), float(high), count)


def nees(errors: Array, covariances: Array) -> Array:
    """(n,) squared errors (n, 2) in units of their covariances (n, 2, 2): 2 on average if honest."""
    return np.asarray(np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariances), errors))
