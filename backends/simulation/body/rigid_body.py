"""A convex body that may touch others."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple, Self

import numpy as np
from scipy.spatial import ConvexHull

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.coal_bodies import coal_body
from handcart.robotics.kinematics.libraries import fcl, pin
from handcart.robotics.kinematics.shapes import Box, Cylinder, Hull, Shape, Sphere
from handcart.robotics.numerics.arrays import FloatArray

MIN_DEPTH_M = 1e-9  # [m]


class RigidBody(NamedTuple):
    """A body's geometry for collision checks, in two libraries.

    FCL decides whether two bodies touch, and coal measures how deep they overlap. Planners use coal. Because
    FCL decides in the simulation, a fault of coal cannot hide a collision of a planned motion.
    """

    judging: object
    measuring: object

    @classmethod
    def of(cls, shape: Shape) -> Self:
        """Create the body of a shape, with its geometry in the shape's own frame."""
        return cls(fcl_body(shape), coal_body(shape))

    @classmethod
    def box(cls, size: FloatArray) -> Self:
        """Create a box of a size (3,) in [m], whose frame is in its middle."""
        x, y, z = size.tolist()
        return cls(*_box(x, y, z))


class Meeting(NamedTuple):
    """Overlap of two bodies: its depth, the direction in which the first body leaves the other, and a
    point.
    """

    depth: float
    """Depth of the overlap, in [m]; 0 if they don't touch."""
    normal: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Unit vector in the common frame along which the first body leaves the other soonest, or zero."""
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Contact point in the common frame, in [m]."""


NO_MEETING = Meeting(0.0)


def meet(one: RigidBody, pose: Transform, other: RigidBody, other_pose: Transform) -> Meeting:
    """Return depth, direction and contact point of the overlap of two bodies.

    Args:
        one: first body.
        pose: (4, 4) pose of the first body, in any common frame.
        other: second body.
        other_pose: (4, 4) pose of the second body, in the same frame.

    Returns:
        The overlap: depth and contact point in [m], and a unit vector, in the common frame; `NO_MEETING` if
            the bodies do not touch.
    """
    if not touch(one.judging, pose, other.judging, other_pose):
        return NO_MEETING
    request, result = pin.coal.CollisionRequest(), pin.coal.CollisionResult()
    if not pin.coal.collide(
        one.measuring, _for_coal(pose), other.measuring, _for_coal(other_pose), request, result
    ):
        return Meeting(MIN_DEPTH_M)
    contact = result.getContact(0)
    (x, y, z), point = (-contact.normal).tolist(), contact.pos.tolist()
    return Meeting(
        max(MIN_DEPTH_M, -float(contact.penetration_depth)), (x, y, z), (point[0], point[1], point[2])
    )


def overlap(one: RigidBody, pose: Transform, other: RigidBody, other_pose: Transform) -> float:
    """Return the depth of the overlap of two bodies at poses (4, 4) in one frame, in [m]; 0 without
    contact.
    """
    return meet(one, pose, other, other_pose).depth


def _for_coal(pose: Transform) -> object:
    return pin.coal.Transform3s(pose[:3, :3], pose[:3, 3])


def fcl_body(shape: Shape) -> object:
    """Convert a shape to a geometry of the collision library FCL, in the shape's own frame."""
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
    """Return True if two geometries of FCL touch or overlap at poses (4, 4) in one common frame."""
    return bool(fcl.collide(_for_fcl(one, pose), _for_fcl(other, other_pose)))


def _for_fcl(geometry: object, pose: Transform) -> object:
    return fcl.CollisionObject(geometry, fcl.Transform(pose[:3, :3], pose[:3, 3]))


@lru_cache(maxsize=1024)
def _box(x: float, y: float, z: float) -> RigidBody:
    """Return a box of that size in [m]; all of one size share a body, because bodies are never changed."""
    return RigidBody.of(Box(np.eye(4), (x, y, z), ""))


@lru_cache(maxsize=256)
def _convex(points: bytes, count: int) -> object:
    corners: FloatArray = np.frombuffer(points).reshape(count, 3)
    hull = ConvexHull(corners, qhull_options="QJ")
    sides = np.insert(hull.simplices, 0, 3, axis=1)  # FCL wants how many corners a side has before them
    return fcl.Convex(corners.copy(), len(sides), sides.ravel())
