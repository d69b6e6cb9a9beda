"""Outline of a base on the floor: a disc, or a polygon around the base's origin."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled

NO_CORNERS = np.empty((0, 2))


class Footprint(NamedTuple):
    """Outline of a base on the floor, a disc or a polygon around the origin of the base frame."""

    radius: float
    """Radius of the circle around the origin that contains the outline, in [m]."""
    corners: FloatArray = NO_CORNERS
    """(n, 2) of a polygon that contains the origin, in order around it, in [m]; empty for a disc."""

    @property
    def is_disc(self) -> bool:
        """True if the outline is a disc of `radius`, False if it is a polygon."""
        return len(self.corners) == 0

    @property
    def inscribed(self) -> float:
        """Radius, in [m], of the largest circle around the base frame's origin that lies inside the
        outline.
        """
        return self.radius if self.is_disc else -polygon_distance(self.corners, 0.0, 0.0)

    def distances(self, points: FloatArray) -> FloatArray:
        """Return the signed distances (m,), in [m], of points (m, 2) in the base frame to the outline;
        negative inside.
        """
        if self.is_disc:
            return np.asarray(np.hypot(points[:, 0], points[:, 1]) - self.radius)
        return np.asarray(polygon_distances(self.corners, np.ascontiguousarray(points, dtype=np.float64)))

    def turned(self, angle: float) -> Footprint:
        """Return the footprint in a frame whose x axis points along `angle` in [rad]."""
        cos, sin = math.cos(angle), math.sin(angle)
        return self._replace(corners=np.ascontiguousarray(self.corners @ np.array([[cos, -sin], [sin, cos]])))

    def outline(self, x: float, y: float, heading: float, parts: int = 48) -> FloatArray:
        """Return the closed outline of a base at a pose on the map for pictures.

        Args:
            x: x of the base on the map, in [m].
            y: y of the base on the map, in [m].
            heading: heading of the base on the map, in [rad].
            parts: number of points on a disc's outline.

        Returns:
            (m, 2) points on the map, in [m]; the last point repeats the first.
        """
        shape = self.corners
        if self.is_disc:
            around = np.linspace(0.0, 2.0 * math.pi, parts, endpoint=False)
            shape = self.radius * np.column_stack([np.cos(around), np.sin(around)])
        cos, sin = math.cos(heading), math.sin(heading)
        turned = shape @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
        return np.vstack([turned, turned[:1]])


def polygon(corners: FloatArray) -> Footprint:
    """Return the footprint with corners (n, 2) in the base frame, in order around its origin, in [m]."""
    kept = np.ascontiguousarray(corners, dtype=np.float64)
    return Footprint(float(np.hypot(*kept.T).max()), kept)


@compiled
def polygon_distance(corners: FloatArray, x: float, y: float) -> float:
    """Return the signed distance of a point to a polygon, in [m]; negative inside.

    Args:
        corners: (n, 2) of the polygon, in order, in any one frame, in [m].
        x: x of the point in the frame of the corners, in [m].
        y: y of the point in the frame of the corners, in [m].
    """
    best, inside = np.inf, False
    last = len(corners) - 1
    for i in range(len(corners)):
        ax, ay, bx, by = corners[last, 0], corners[last, 1], corners[i, 0], corners[i, 1]
        dx, dy = bx - ax, by - ay
        at = ((x - ax) * dx + (y - ay) * dy) / max(dx * dx + dy * dy, 1e-18)
        at = min(max(at, 0.0), 1.0)
        best = min(best, (ax + at * dx - x) ** 2 + (ay + at * dy - y) ** 2)
        if (ay > y) != (by > y) and x < ax + (y - ay) * dx / dy:
            inside = not inside
        last = i
    away = math.sqrt(best)
    return -away if inside else away


@compiled
def polygon_distances(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Return the signed distances of points to a polygon; negative inside.

    Args:
        corners: (n, 2) of the polygon, in order, in any one frame, in [m].
        points: (m, 2) in the frame of the corners, in [m].

    Returns:
        (m,) in [m].
    """
    found = np.empty(len(points))
    for i in range(len(points)):
        found[i] = polygon_distance(corners, points[i, 0], points[i, 1])
    return found


@compiled
def polygon_gap(one: FloatArray, other: FloatArray) -> float:
    """Return the distance between two polygons, in [m]; negative where they overlap.

    For an overlap, the result is minus the depth of the deepest corner inside the other polygon, or -1e-6 if
    only sides cross.

    Args:
        one: (n, 2) corners in order, in any one frame, in [m].
        other: (m, 2) corners in order in the same frame, in [m].
    """
    gap = np.inf
    for i in range(len(one)):
        gap = min(gap, polygon_distance(other, one[i, 0], one[i, 1]))
    for i in range(len(other)):
        gap = min(gap, polygon_distance(one, other[i, 0], other[i, 1]))
    if gap <= 0.0:
        return gap
    last = len(one) - 1
    for i in range(len(one)):
        end = len(other) - 1
        for j in range(len(other)):
            if _cross(one[last], one[i], other[end], other[j]):
                return -1e-6
            end = j
        last = i
    return gap


@compiled
def _side(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    side: float = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return side


@compiled
def _cross(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> bool:
    """Return True if the segments ab and cd cross; all four are points (2,) of one frame."""
    return _side(a, b, c) * _side(a, b, d) < 0.0 and _side(c, d, a) * _side(c, d, b) < 0.0
