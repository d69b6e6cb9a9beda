"""Places where sensors are laid beside the base, and the radius that holds a share of them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

TARGET_OFFSET_M = 0.75  # [m] from the base to the target on its right
MIN_PLACEMENTS = {0.95: 59, 0.997: 998}  # placements below which a share isn't claimed, with 95 % confidence


class Radius(NamedTuple):
    """Within which a share of the placements lies."""

    share: float
    radius: float
    """Radius in [m]."""
    low: float
    high: float
    """95 % of what other runs would have given, drawn by run, in [m]."""
    placements: int


def tip_place(pose: Pose2) -> FloatArray:
    """Return (2,) where a sensor is laid from this base, in [m]."""
    return pose.apply(np.array([[0.0, -TARGET_OFFSET_M]])).reshape(2)


def tip_covariance(covariance: FloatArray, heading: float) -> FloatArray:
    """Return (2, 2) of `tip_place` in [m²] by the covariance (3, 3) of the base's pose."""
    by_pose = np.array(
        [[1.0, 0.0, TARGET_OFFSET_M * math.cos(heading)], [0.0, 1.0, TARGET_OFFSET_M * math.sin(heading)]]
    )
    spread: FloatArray = by_pose @ covariance @ by_pose.T
    return spread


def share_radius(errors: list[FloatArray], share: float, seed: int = 0, draws: int = 1000) -> Radius | None:
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
