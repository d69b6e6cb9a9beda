"""Points that the lidar sees and the map does not show."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.scans.scan_matching import LikelihoodField
from handcart.robotics.numerics.arrays import FloatArray

MIN_APPROACH_M = 0.005
"""Approach of the route to a point that is too near already, from which on the point blocks the route."""


def unexpected_points(points: FloatArray, field: LikelihoodField, margin: float) -> FloatArray:
    """Return the scan points at which the map shows nothing that the lidar could have met.

    Two sorts of points are left out: those within `margin` of an occupied cell, and those in unknown cells,
    because an unknown cell may contain anything.

    Args:
        points: (n, 2) in the map frame, in [m].
        field: likelihood field of the map.
        margin: pose error, sensor noise and half a cell together, in [m].

    Returns:
        (m, 2) in [m], in the order of `points`.
    """
    if len(points) == 0:
        return np.empty((0, 2))
    grid = field.map
    away = points[field.read(points) > margin]  # few of them: the rest is asked of no more
    there = away[grid.inside(away)]
    rows, columns = grid.to_cell(there).T
    unexplained: FloatArray = there[~(grid.occupied[rows, columns] | grid.unknown[rows, columns])]
    return unexplained


def path_blocked(
    route: FloatArray,
    points: FloatArray,
    radius: float,
    horizon: float,
    fewest: int = 2,
) -> tuple[float, FloatArray] | None:
    """Return where along a route a robot would first touch a sensed point; None if the route is free.

    A point is ignored if it is nearer than `radius` already at the start, and the route only leads away from
    it.

    Args:
        route: (n, 2) the route ahead, from where the robot is, on the map, in [m].
        points: (m, 2) sensed points in the same frame, in [m].
        radius: radius of the robot plus the wanted margin, in [m].
        horizon: length of the route that is checked, in [m].
        fewest: least number of touched points; a single one may be noise.

    Returns:
        How far along the route the robot's centre gets before touching, in [m], and the point (2,) that it
        touches.
    """
    if len(route) == 0 or len(points) < fewest:
        return None
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(route, axis=0).T))])
    end = min(horizon, float(along[-1]))
    at = np.linspace(0.0, end, max(2, int(end / (0.1 * radius)) + 1))
    centres = np.column_stack([np.interp(at, along, route[:, i]) for i in (0, 1)])
    away = np.hypot(*(centres[:, None] - points[None]).transpose(2, 0, 1))
    near = away < radius
    near &= ~near[0] | (away.min(axis=0) < away[0] - MIN_APPROACH_M)
    if np.count_nonzero(near.any(axis=0)) < fewest:
        return None
    first = int(np.argmax(near.any(axis=1)))
    touched = int(np.argmin(np.where(near[first], np.hypot(*(points - centres[first]).T), np.inf)))
    return float(at[first]), points[touched]
