"""Kalman filters of bodies at constant velocity, many at a time (Bar-Shalom et al., 2001, ch. 6)."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from handcart.robotics.numerics.arrays import FloatArray

GATE_D2 = 13.8  # squared Mahalanobis distance that 99.9 % of the right measurements keep
GATE_M = 0.7  # the same in [m], at most
FAR_COST = 1e6  # of pairs beyond the gate


def predict(
    means: FloatArray, covariances: FloatArray, dt: float, density: float
) -> tuple[FloatArray, FloatArray]:
    """Return predicted means (n, 4) and covariances (n, 4, 4) of tracks after a time, at constant velocity.

    Args:
        means: (n, 4) x, y on the map in [m] and velocity along them in [m/s].
        covariances: (n, 4, 4) of the means, in their units.
        dt: time, in [s].
        density: power density of the white acceleration along each axis, in [m²/s³].
    """
    F = np.eye(4)
    F[0, 2] = F[1, 3] = dt
    Q = np.zeros((4, 4))
    Q[[0, 1], [0, 1]] = density * dt**3 / 3.0
    Q[[0, 1, 2, 3], [2, 3, 0, 1]] = density * dt**2 / 2.0
    Q[[2, 3], [2, 3]] = density * dt
    return means @ F.T, F @ covariances @ F.T + Q


def assign(
    means: FloatArray, covariances: FloatArray, measured: FloatArray, noises: FloatArray
) -> list[tuple[int, int]]:
    """Return the most likely assignment of measurements to tracks, as pairs of a track's and a measurement's
    number.

    Pairs more than `GATE_M` apart, or with a squared Mahalanobis distance above `GATE_D2`, are left out.

    Args:
        means: (n, 4) predicted x, y on the map in [m] and velocity along them in [m/s].
        covariances: (n, 4, 4) of the means, in their units.
        measured: (m, 2) positions on the map, in [m].
        noises: (m, 2, 2) covariance of each measured position along the same axes, in [m²].
    """
    if not len(means) or not len(measured):
        return []
    off = measured[None] - means[:, None, :2]
    spread = covariances[:, None, :2, :2] + noises[None]
    determinant = spread[..., 0, 0] * spread[..., 1, 1] - spread[..., 0, 1] ** 2
    d2 = spread[..., 1, 1] * off[..., 0] ** 2 + spread[..., 0, 0] * off[..., 1] ** 2
    d2 = (d2 - 2.0 * spread[..., 0, 1] * off[..., 0] * off[..., 1]) / determinant
    open_gate = (d2 <= GATE_D2) & (np.hypot(off[..., 0], off[..., 1]) <= GATE_M)
    cost = np.where(open_gate, d2 + np.log(determinant), FAR_COST)
    rows, columns = linear_sum_assignment(cost)
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if open_gate[i, j]]


def correct(
    means: FloatArray, covariances: FloatArray, measured: FloatArray, noises: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return corrected means (n, 4) and covariances (n, 4, 4) of tracks, each by its own measured position.

    Args:
        means: (n, 4) x, y on the map in [m] and velocity along them in [m/s].
        covariances: (n, 4, 4) of the means, in their units.
        measured: (n, 2) measured position of each track on the map, in [m].
        noises: (n, 2, 2) covariance of each measured position along the same axes, in [m²].
    """
    spread = covariances[:, :2, :2] + noises
    gain = covariances[:, :, :2] @ np.linalg.inv(spread)
    means = means + (gain @ (measured - means[:, :2])[..., None])[..., 0]
    left = np.eye(4) - np.concatenate([gain, np.zeros((len(means), 4, 2))], axis=2)
    covariances = left @ covariances @ left.transpose(0, 2, 1) + gain @ noises @ gain.transpose(0, 2, 1)
    return means, covariances
