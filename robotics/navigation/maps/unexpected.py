"""What the sensor sees and the map doesn't show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.navigation.localization.scan_matching import LikelihoodField


def unexpected_points(
    points: NDArray[np.float64], field: LikelihoodField, margin: float
) -> NDArray[np.float64]:
    """Those scan points that the map doesn't explain.

    A point is explained by an occupied cell within `margin`, in [m], and by not lying in a free cell: where
    the map knows nothing, anything may stand.

    Args:
        points: (n, 2) in the map frame, in [m].
        field: of the map.
        margin: pose error, sensor noise and half a cell together, in [m].

    Returns:
        (m, 2) in [m], in the order of `points`.
    """
    inside = points[field.map.inside(points)] if len(points) else np.empty((0, 2))
    rows, columns = field.map.to_cell(inside).T
    free = ~field.map.blocked[rows, columns]
    unexplained: NDArray[np.float64] = inside[free & (field.read(inside) > margin)]
    return unexplained


def path_blocked(
    route: NDArray[np.float64],
    points: NDArray[np.float64],
    radius: float,
    horizon: float,
    fewest: int = 2,
) -> tuple[float, NDArray[np.float64]] | None:
    """Where along a route a robot would touch sensed points.

    Args:
        route: (n, 2) the route ahead, from where the robot is, in [m].
        points: (m, 2) sensed points in the same frame, in [m].
        radius: of the robot, with what margin is wanted, in [m].
        horizon: how far along the route to look, in [m].
        fewest: points that must be in the way; a lone one may be noise.

    Returns:
        How far along the route the robot's centre gets before touching, in [m], and the point (2,) that it
        touches; None if nothing is in the way.
    """
    if len(route) == 0 or len(points) < fewest:
        return None
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(route, axis=0).T))])
    end = min(horizon, float(along[-1]))
    at = np.linspace(0.0, end, max(2, int(end / (0.1 * radius)) + 1))
    centres = np.column_stack([np.interp(at, along, route[:, i]) for i in (0, 1)])
    near = np.hypot(*(centres[:, None] - points[None]).transpose(2, 0, 1)) < radius
    if np.count_nonzero(near.any(axis=0)) < fewest:
        return None
    first = int(np.argmax(near.any(axis=1)))
    touched = int(np.argmin(np.where(near[first], np.hypot(*(points - centres[first]).T), np.inf)))
    return float(at[first]), points[touched]
