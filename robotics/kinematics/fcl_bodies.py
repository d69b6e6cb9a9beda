"""Convex bodies as FCL (python-fcl) has them: it judges whether anything touched; coal plans."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.libraries import fcl
from handcart.robotics.kinematics.shapes import Box, Cylinder, Hull, Shape, Sphere


def fcl_body(shape: Shape) -> object:
    """A shape as FCL's geometry, about the origin of its frame."""
    match shape:
        case Box():
            return fcl.Box(*shape.size)
        case Cylinder():
            return fcl.Cylinder(shape.radius, shape.length)
        case Sphere():
            return fcl.Sphere(shape.radius)
        case Hull():
            return _convex(shape.points.tobytes(), len(shape.points))


def touch(one: object, pose: Transform, other: object, other_pose: Transform) -> bool:
    """Whether two geometries of FCL overlap, or touch, at these poses (4, 4)."""
    return bool(fcl.collide(_placed(one, pose), _placed(other, other_pose)))


def _placed(geometry: object, pose: Transform) -> object:
    return fcl.CollisionObject(geometry, fcl.Transform(pose[:3, :3], pose[:3, 3]))


@lru_cache(maxsize=256)
def _convex(points: bytes, count: int) -> object:
    corners: NDArray[np.float64] = np.frombuffer(points).reshape(count, 3)
    hull = ConvexHull(corners, qhull_options="QJ")
    sides = np.insert(hull.simplices, 0, 3, axis=1)  # FCL wants how many corners a side has before them
    return fcl.Convex(corners.copy(), len(sides), sides.ravel())
