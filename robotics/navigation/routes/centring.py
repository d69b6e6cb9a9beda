"""Shift of a route to the middle of narrow places as sensed: a map draws doors off by half a cell."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.numerics.arrays import FloatArray

from .swept_route import travel_headings

AHEAD_M = 1.6  # of route that is shifted
NARROW_M = 0.12  # beside the footprint on each side, beyond which a place is not narrow
MAX_SHIFT_M = 0.06
SMOOTH_M = 0.3  # of route, over which the shift changes
NTH_NEAREST = 1  # of the points on a side, that counts: the nearest one may be noise


def centred(points: FloatArray, shape: Footprint, sensed: FloatArray) -> tuple[FloatArray, float]:
    """Return a route shifted to the middle of narrow places.

    A place is narrow if things are within `NARROW_M` of the footprint on both sides. Only the first `AHEAD_M`
    of the route are shifted, by `MAX_SHIFT_M` at most.

    Args:
        points: (n, 2) the rest of the route, beginning at the robot, on the map, in [m].
        shape: polygon of the footprint.
        sensed: (m, 2) points that the lidar sees, on the map, in [m].

    Returns:
        The route (n, 2) on the map, and its largest shift, both in [m].
    """
    if len(points) < 2 or not len(sensed):
        return points, 0.0
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    near = int(np.searchsorted(along, AHEAD_M))
    headings, shift = travel_headings(points), np.zeros(len(points))
    for i in range(min(near, len(points))):
        shift[i] = _off_middle(sensed - points[i], float(headings[i]), shape)
    window = np.abs(along[:, None] - along[None]) < 0.5 * SMOOTH_M
    tight = window & (np.abs(shift) > 0.0)[None]
    weights = np.maximum(tight.sum(axis=1), 1)
    smooth = (tight * shift).sum(axis=1) / weights
    smooth *= np.clip(along / SMOOTH_M, 0.0, 1.0) * np.clip((along[-1] - along) / SMOOTH_M, 0.0, 1.0)
    left = np.column_stack([-np.sin(headings), np.cos(headings)])
    return points + smooth[:, None] * left, float(np.abs(smooth).max())


def _off_middle(sensed: FloatArray, heading: float, shape: Footprint) -> float:
    """Return the way to the left from a point of the route to the middle of a narrow place, in [m]."""
    cos, sin = np.cos(heading), np.sin(heading)
    ahead, left = sensed[:, 0] * cos + sensed[:, 1] * sin, sensed[:, 1] * cos - sensed[:, 0] * sin
    low, high = shape.corners.min(axis=0), shape.corners.max(axis=0)
    beside = left[(ahead > low[0]) & (ahead < high[0])]
    rooms = np.sort(beside[beside > 0.0])[: NTH_NEAREST + 1] - high[1]
    others = np.sort(-beside[beside <= 0.0])[: NTH_NEAREST + 1] + low[1]
    if len(rooms) <= NTH_NEAREST or len(others) <= NTH_NEAREST:
        return 0.0
    room, other = float(rooms[-1]), float(others[-1])
    if max(room, other) > NARROW_M or room + other < 0.0:
        return 0.0
    return float(np.clip(0.5 * (room - other), -MAX_SHIFT_M, MAX_SHIFT_M))
