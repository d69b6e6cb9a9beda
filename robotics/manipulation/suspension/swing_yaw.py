"""Yaw of the base for each swing of the arm, estimated from its heading between the swings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

_FEWEST = 3  # of steps between stops


class SwingYaw(NamedTuple):
    """Mean yaw by which a swing of the arm turns its base on springs, with the scatter between swings."""

    yaw_per_swing: float
    """Mean yaw for each move of the arm out and back, in [rad], positive to the left."""
    sigma: float
    """Standard error of the mean, in [rad]."""
    spread: float
    """Standard deviation of the yaw of a single swing, in [rad]."""
    spread_sigma: float
    """Standard error of the spread, in [rad]."""
    noise: float
    """Standard deviation of one measured heading, in [rad]."""


def fit_swing_yaw(headings: FloatArray, swings: int) -> SwingYaw:
    """Estimate the base's yaw for each swing of the arm, with its scatter, from headings between swings.

    The yaws of different swings are assumed to be independent.

    Args:
        headings: (n, m) headings of the base in any one frame, in [rad], positive to the left: m measurements
            at each of n stops with the same posture. The arm does not swing during a stop.
        swings: number of moves of the arm out and back between one stop and the next.

    Raises:
        ValueError: there are too few stops, measurements or swings.
    """
    stops, looks = headings.shape
    if stops <= _FEWEST or looks < 2 or swings < 1:
        raise ValueError(
            f"{stops} stops with {looks} looks and {swings} swings between can't determine the yaw; needed: "
            f"more than {_FEWEST} stops, 2 looks, 1 swing"
        )
    noise = float(np.sqrt(headings.var(axis=1, ddof=1).mean()))
    steps = np.diff(headings.mean(axis=1))
    # A step is what its swings did, and the noise of the stops at both its ends.
    scatter = float(steps.var(ddof=1))
    of_swings = max(0.0, scatter - 2.0 * noise**2 / looks)
    count = len(steps)
    # The steps add up to the way from first to last: the stops between don't count in the mean.
    of_mean = of_swings / count + 2.0 * noise**2 / looks / count**2
    spread = float(np.sqrt(of_swings / swings))
    # The standard deviation of a variance from n steps is sqrt(2 / (n - 1)) of it.
    of_spread = float(np.sqrt(scatter / swings / (2.0 * (count - 1))))
    return SwingYaw(float(steps.mean()) / swings, float(np.sqrt(of_mean)) / swings, spread, of_spread, noise)
