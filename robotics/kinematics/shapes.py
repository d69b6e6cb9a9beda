"""Convex bodies of robot links, furniture and held objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Box:
    """A box centred at `pose` (4, 4), with `size` along its own x, y, z in [m]."""

    pose: Transform
    size: tuple[float, float, float]
    name: str = "box"

    def seen_from(self, a_T_b: Transform) -> Box:
        """Return the box posed in the frame a, given its pose in the frame b and the pose a_T_b."""
        return Box(a_T_b @ self.pose, self.size, self.name)


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder centred at `pose` (4, 4), axis along its own z; `radius`, `length` in [m]."""

    pose: Transform
    radius: float
    length: float
    name: str = "cylinder"

    def seen_from(self, a_T_b: Transform) -> Cylinder:
        """Return the cylinder posed in the frame a, given its pose in the frame b and the pose a_T_b."""
        return Cylinder(a_T_b @ self.pose, self.radius, self.length, self.name)


@dataclass(frozen=True, eq=False)
class Sphere:
    """A ball centred at `pose` (4, 4), `radius` in [m]."""

    pose: Transform
    radius: float
    name: str = "sphere"


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull of `points` (n, 3), in [m], which are given in a frame whose pose (4, 4) is `pose`."""

    pose: Transform
    points: FloatArray
    name: str = "hull"


Solid = Box | Cylinder
"""Shapes of surrounding bodies."""
Shape = Box | Cylinder | Sphere | Hull


def corners(shape: Shape) -> FloatArray:
    """Return points (k, 3), in [m], whose convex hull contains a body, in the frame in which it is posed."""
    if isinstance(shape, Hull):
        points = shape.points
    else:
        match shape:
            case Box():
                size = np.array(shape.size)
            case Cylinder():
                size = np.array([2.0 * shape.radius, 2.0 * shape.radius, shape.length])
            case Sphere():
                size = np.full(3, 2.0 * shape.radius)
        points = 0.5 * size * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return np.asarray(points @ shape.pose[:3, :3].T + shape.pose[:3, 3])


def radius_about(shape: Shape) -> float:
    """Return the radius, in [m], of the smallest ball about the origin of a body's own frame that contains
    the body.
    """
    match shape:
        case Box():
            return float(np.linalg.norm(shape.size)) / 2
        case Cylinder():
            return float(np.hypot(shape.radius, shape.length / 2))
        case Sphere():
            return shape.radius
        case Hull():
            return float(np.linalg.norm(shape.points, axis=1).max())


def top(shape: Shape) -> float:
    """Return the height, in [m], of the highest point of a body, along z of the frame in which it is
    posed.
    """
    return float(shape.pose[2, 3]) + _reach(shape, shape.pose[2, :3])


def bottom(shape: Shape) -> float:
    """Return the height, in [m], of the lowest point of a body, along z of the frame in which it is posed."""
    return float(shape.pose[2, 3]) - _reach(shape, -shape.pose[2, :3])


def _reach(shape: Shape, way: FloatArray) -> float:
    """Return how far a body reaches from its origin along a unit vector (3,) of its own frame, in [m]."""
    match shape:
        case Box():
            return float(np.abs(way) @ np.array(shape.size)) / 2
        case Cylinder():
            return shape.radius * float(np.hypot(way[0], way[1])) + shape.length / 2 * abs(float(way[2]))
        case Sphere():
            return shape.radius
        case Hull():
            return float((shape.points @ way).max())
