"""Set-points in time along a path, within the limits of each joint."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from handcart.robotics.manipulation.motions.rounded_path import RoundedPath
from handcart.robotics.numerics.arrays import FloatArray


def time_path(
    path: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    period: float,
    deviation: float = 0.005,
) -> FloatArray:
    """Return joint set-points (k, n), in [rad] or [m], from the path's start to its end, at rest at both.

    There is one set-point for each `period`.

    The path is followed as fast as the limits allow: its corners are rounded by arcs, then TOPP-RA (Pham and
    Pham 2018) computes the highest speed along it that keeps the limits. At corners where the path reverses
    its direction the arm stops.

    Args:
        path: waypoints (m, n) joined by straight lines, in [rad] or [m].
        velocity: limits (n,), in [rad/s] or [m/s]; differences of successive set-points, divided by the
            period, keep them, from and to rest.
        acceleration: limits (n,), in [rad/s²] or [m/s²]; second differences of the set-points, divided by the
            squared period, keep them.
        period: time between set-points, in [s].
        deviation: allowed distance of the set-points from the lines at a corner, in [rad] over all joints
            (1 m counts as 1 rad); check the path with a margin that covers it (0.005 rad move a fingertip by
            at most 5 mm).

    Raises:
        ValueError: a limit, the period or the deviation isn't above zero.
    """
    if min(*velocity, *acceleration, period, deviation) <= 0.0:
        raise ValueError("velocity, acceleration, period and deviation must be above zero")
    path = np.asarray(path, dtype=np.float64)
    moved = np.linalg.norm(np.diff(path, axis=0), axis=1) > _STILL
    corners = path[np.concatenate(([True], moved))]
    rows = [
        _time_smooth(RoundedPath(piece, deviation), velocity, acceleration, period)[1:]
        for piece in _between_stops(corners)
    ]
    return np.vstack((path[:1], *rows))


_STILL = 1e-9  # [rad]
_REVERSAL = -0.98  # cosine of a corner that is too sharp to be rounded


def _between_stops(corners: FloatArray) -> list[FloatArray]:
    if len(corners) < 2:
        return []
    steps = np.diff(corners, axis=0)
    directions = steps / np.linalg.norm(steps, axis=1)[:, None]
    cosines = np.sum(directions[:-1] * directions[1:], axis=1)
    stops = [0, *(np.flatnonzero(cosines < _REVERSAL) + 1), len(corners) - 1]
    return [corners[a : b + 1] for a, b in pairwise(stops)]


def _time_smooth(
    rounded: RoundedPath, velocity: FloatArray, acceleration: FloatArray, period: float
) -> FloatArray:
    # toppra loads much of scipy: half a second for programs that never move an arm.
    from handcart.robotics.manipulation.motions.path_speed import highest_speed

    s, speed = highest_speed(rounded, velocity, acceleration)
    times = np.concatenate(([0.0], np.cumsum(2.0 * np.diff(s) / (speed[:-1] + speed[1:]))))
    count = max(2, int(np.ceil(times[-1] / period)))
    while True:
        set_points = rounded.at(_progress(s, speed, times, np.linspace(0.0, times[-1], count + 1)))
        excess = _excess(set_points, velocity, acceleration, period)
        if excess <= 1.0:
            return set_points
        # Stretching in time lowers speeds by its factor and accelerations by its square.
        count = max(count + 1, int(count * min(excess, 1.5) ** 0.5))


def _progress(s: FloatArray, speed: FloatArray, times: FloatArray, at: FloatArray) -> FloatArray:
    """Return arc lengths (k,) in [rad] at the times `at` (k,) in [s].

    Acceleration is constant between the points of the grid, which have arc lengths `s` (g,), speeds `speed`
    (g,) and times `times` (g,).
    """
    index = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(s) - 2)
    dt = at - times[index]
    span = times[index + 1] - times[index]
    gain = (speed[index + 1] - speed[index]) / span
    return np.clip(s[index] + speed[index] * dt + 0.5 * gain * dt * dt, 0.0, s[-1])


def _excess(set_points: FloatArray, velocity: FloatArray, acceleration: FloatArray, period: float) -> float:
    """Return the factor by which the limits are exceeded: of accelerations, or of squared speeds."""
    rest = np.zeros((1, set_points.shape[1]))
    speeds = np.vstack((rest, np.diff(set_points, axis=0) / period, rest))
    fastest = float(np.max(np.abs(speeds) / velocity))
    hardest = float(np.max(np.abs(np.diff(speeds, axis=0)) / (period * acceleration)))
    return max(fastest * abs(fastest), hardest)
