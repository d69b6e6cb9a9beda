"""Straight passes through narrow places: a route from cell to cell leads through a door a little askew."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray

from .swept_route import travel_headings

MAX_TURN_RAD = 0.6  # between a route's heading at a narrow place and that of a straight pass
TURN_STEP_RAD = 0.03
PASS_LENGTHS = (1.6, 1.2, 0.9)  # of the footprint: straight before and behind the place, in turn
JOIN_M = 0.15  # of route, removed at both ends of a pass, so that it turns into it
SPACING_M = 0.03  # between points of a pass


def straight_passes(
    grid: GridMap, shape: Footprint, points: FloatArray, spot: FloatArray
) -> list[FloatArray]:
    """Return variants of a route that lead straight through the middle of a narrow place.

    Each route is (k, 2) on the map, in [m]. The route with the longest straight part is the first.

    Args:
        grid: the map; unknown cells count as blocked.
        shape: polygon of the footprint.
        points: (n, 2) route on the map, in [m].
        spot: (2,) point of the route on the map where the place is narrow, in [m].
    """
    nearest = int(np.argmin(np.hypot(*(points - spot).T)))
    heading = float(travel_headings(points)[nearest])
    low, high = shape.corners.min(axis=0), shape.corners.max(axis=0)
    around = _blocked_near(grid, spot, PASS_LENGTHS[0] * float(high[0] - low[0]) + shape.radius)
    found = []
    for ratio in PASS_LENGTHS:
        half = ratio * float(high[0] - low[0])
        middle = _widest(around - spot, heading, (low[0] - half, high[0] + half), 0.5 * (low[1] + high[1]))
        if middle is not None:
            along = np.array([math.cos(middle[0]), math.sin(middle[0])])
            centre = spot + middle[1] * np.array([-along[1], along[0]])
            found.append(_joined(points, centre, along, half))
    return found


def _blocked_near(grid: GridMap, spot: FloatArray, reach: float) -> FloatArray:
    """Return the centres (k, 2) of blocked cells within a square around a point, in [m]."""
    (row, column), cells = grid.to_cell(spot[None])[0].tolist(), math.ceil(reach / grid.resolution)
    top, left = max(0, row - cells), max(0, column - cells)
    rows, columns = np.nonzero(grid.blocked[top : row + cells + 1, left : column + cells + 1])
    return grid.to_point(np.column_stack([rows + top, columns + left]))


def _widest(
    off: FloatArray, heading: float, window: tuple[float, float], middle: float
) -> tuple[float, float] | None:
    """Return heading and shift to the left of the widest straight pass; None if nothing is on one side.

    Args:
        off: (k, 2) obstacles from the narrow place, in [m].
        heading: of the route there, in [rad].
        window: of length along the pass, within which obstacles count, in [m].
        middle: of the footprint, to the left of its origin, in [m].
    """
    angles = heading + np.arange(-MAX_TURN_RAD, MAX_TURN_RAD + 1e-9, TURN_STEP_RAD)
    along = off @ np.stack([np.cos(angles), np.sin(angles)])
    left = off @ np.stack([-np.sin(angles), np.cos(angles)])
    inside = (along > window[0]) & (along < window[1])
    lefts = np.where(inside & (left > 0.0), left, np.inf).min(axis=0, initial=np.inf)
    rights = np.where(inside & (left <= 0.0), left, -np.inf).max(axis=0, initial=-np.inf)
    widths = np.where(np.isfinite(lefts) & np.isfinite(rights), lefts - rights, -np.inf)
    best = int(np.argmax(widths))
    if not np.isfinite(widths[best]):
        return None
    return float(angles[best]), float(0.5 * (lefts[best] + rights[best])) - middle


def _joined(points: FloatArray, centre: FloatArray, along: FloatArray, half: float) -> FloatArray:
    """Return a route (n, 2) whose part within a straight pass is replaced by it."""
    away = np.hypot(*(points - centre).T) < half + JOIN_M
    first, last = int(np.argmax(away)), len(points) - 1 - int(np.argmax(away[::-1]))
    straight = np.arange(-half, half + 1e-9, SPACING_M)[:, None] * along + centre
    before, behind = points[:first], points[last + 1 :]
    if not len(before):
        before = points[:1]
        straight = straight[(straight - before[0]) @ along > 0.0]
    if not len(behind):
        behind = points[-1:]
        straight = straight[(behind[0] - straight) @ along > 0.0]
    return _filled(np.vstack([before, straight, behind]))


def _filled(points: FloatArray) -> FloatArray:
    """Return a route (n, 2) with points no farther apart than `SPACING_M`."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    more = [np.linspace(a, b, math.ceil((b - a) / SPACING_M), endpoint=False) for a, b in _gaps(along)]
    at = np.unique(np.concatenate([along, *more]))
    return np.column_stack([np.interp(at, along, points[:, i]) for i in (0, 1)])


def _gaps(along: FloatArray) -> list[tuple[float, float]]:
    """Return beginnings and ends of the steps longer than `SPACING_M`."""
    wide = np.flatnonzero(np.diff(along) > SPACING_M)
    return [(float(along[i]), float(along[i + 1])) for i in wide]
