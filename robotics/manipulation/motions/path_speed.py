"""Highest speed along a path within the limits of each joint."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from handcart.robotics.manipulation.motions.rounded_path import RoundedPath
from handcart.robotics.numerics.arrays import FloatArray

from .toppra_library import (
    AbstractGeometricPath,
    JointAccelerationConstraint,
    JointVelocityConstraint,
    SeidelToppra,
)


def highest_speed(
    rounded: RoundedPath, velocity: FloatArray, acceleration: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the highest possible speed along a joint path as a function of arc length, from rest to rest.

    The method is TOPP-RA (Pham and Pham 2018): a backward pass along the path finds the speeds from which the
    arm can still stop in time; a forward pass takes the highest of them.

    Args:
        rounded: the path, in [rad] or [m].
        velocity: (n,) velocity limits of the joints, in [rad/s] or [m/s].
        acceleration: (n,) acceleration limits of the joints, in [rad/s²] or [m/s²].

    Returns:
        Arc lengths (g,) in [rad], and the speed at each (g,) in [rad/s]; 1 m counts as 1 rad.

    Raises:
        RuntimeError: no speed profile keeps the limits.
    """
    velocity, acceleration = np.asarray(velocity, dtype=np.float64), np.asarray(acceleration, np.float64)
    limits = _limits(velocity.tobytes(), acceleration.tobytes())
    grid = _grid(rounded.knots)
    solver = SeidelToppra(list(limits), _Path(rounded), grid)
    _, speed, _ = solver.compute_parameterization(0.0, 0.0)
    if speed is None or not np.all(np.isfinite(speed)):
        raise RuntimeError("TOPP-RA found no speed along a path from rest to rest")
    return grid, np.maximum(speed, 0.0)


@lru_cache(maxsize=16)
def _limits(velocity: bytes, acceleration: bytes) -> tuple[object, object]:
    """Return toppra's constraints for limits given as the bytes of their (n,) numbers.

    They do not change, and toppra describes each in words, which takes as long as a short path's speeds.
    """
    fastest, hardest = np.frombuffer(velocity), np.frombuffer(acceleration)
    return (
        JointVelocityConstraint(np.column_stack((-fastest, fastest))),
        JointAccelerationConstraint(np.column_stack((-hardest, hardest))),
    )


def _grid(knots: FloatArray) -> FloatArray:
    """Return the knots (k,) in [rad] with each piece divided into 4 parts or more, of 0.02 rad at most."""
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
