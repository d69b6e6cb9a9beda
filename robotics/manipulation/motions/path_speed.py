"""Highest speed along a path within the limits of each joint."""

from __future__ import annotations

import numpy as np

from handcart.robotics.manipulation.motions.rounded_path import RoundedPath
from handcart.robotics.numerics.arrays import FloatArray

from .toppra_library import (
    TOPPRA,
    AbstractGeometricPath,
    JointAccelerationConstraint,
    JointVelocityConstraint,
)


def highest_speed(
    rounded: RoundedPath, velocity: FloatArray, acceleration: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the highest speed along a path at its arc lengths, starting and ending at rest.

    Source: TOPP-RA, Pham and Pham 2018.

    Args:
        rounded: the path, in [rad].
        velocity: (n,) limits, in [rad/s].
        acceleration: (n,) limits, in [rad/s²].

    Returns:
        Arc lengths (g,) in [rad], and the speed at each (g,) in [rad/s].

    Raises:
        RuntimeError: no speed profile keeps the limits.
    """
    limits = [
        JointVelocityConstraint(np.column_stack((-velocity, velocity))),
        JointAccelerationConstraint(np.column_stack((-acceleration, acceleration))),
    ]
    grid = _grid(rounded.knots)
    solver = TOPPRA(limits, _Path(rounded), gridpoints=grid, solver_wrapper="seidel")
    _, speed, _ = solver.compute_parameterization(0.0, 0.0)
    if speed is None or not np.all(np.isfinite(speed)):
        raise RuntimeError("TOPP-RA found no speed along a path from rest to rest")
    return grid, np.maximum(speed, 0.0)


def _grid(knots: FloatArray) -> FloatArray:
    """Return the knots, with each piece divided into at least 4 parts of at most 0.02 rad."""
    counts = np.maximum(4, np.ceil(np.diff(knots) / 0.02).astype(int))
    parts = [
        np.linspace(a, b, count, endpoint=False)
        for a, b, count in zip(knots[:-1], knots[1:], counts, strict=True)
    ]
    return np.concatenate((*parts, knots[-1:]))


class _Path(AbstractGeometricPath):  # type: ignore[misc]
    """A rounded path in the form that toppra asks."""

    def __init__(self, rounded: RoundedPath) -> None:
        self._rounded = rounded

    def __call__(self, path_positions: FloatArray, order: int = 0) -> FloatArray:
        return self._rounded.at(np.atleast_1d(path_positions), order)

    @property
    def dof(self) -> int:
        return self._rounded.dof

    @property
    def path_interval(self) -> FloatArray:
        return np.array([0.0, self._rounded.length])

    @property
    def waypoints(self) -> None:
        return None
