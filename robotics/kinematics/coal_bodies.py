"""Conversion of convex bodies to and from coal, the collision checker that comes with Pinocchio."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.kinematics.shapes import Box, Cylinder, Hull, Shape, Sphere
from handcart.robotics.numerics.arrays import FloatArray

_LEAST = 4  # corners of a body
_WORDS = 200  # of what the library says
_CELLS = (200, 100, 50, 25)  # that a mesh is divided into along its longest side


@cache
def meshes() -> Any:
    """Return the mesh loader of coal, the collision library; it reads each mesh once for all models."""
    return pin.coal.CachedMeshLoader()


def coal_body(shape: Shape) -> object:
    """Return a shape as a geometry of coal, the collision library, about the origin of the shape's frame."""
    match shape:
        case Box():
            return pin.coal.Box(*shape.size)
        case Cylinder():
            return pin.coal.Cylinder(shape.radius, shape.length)
        case Sphere():
            return pin.coal.Sphere(shape.radius)
        case Hull():
            return _convex(shape.points.tobytes(), len(shape.points))


def shape_of(geometry: object, pose: Transform, name: str) -> Shape:
    """Return a geometry of coal, the collision library, as a shape; a mesh becomes its convex hull.

    Args:
        geometry: coal's geometry.
        pose: (4, 4) pose of the geometry in the frame of the returned shape.
        name: name of the shape.

    Raises:
        ValueError: the geometry is neither box, cylinder, sphere nor convex mesh.
    """
    match geometry:
        case pin.coal.Box():
            x, y, z = (2.0 * float(half) for half in geometry.halfSide)
            return Box(pose, (x, y, z), name)
        case pin.coal.Cylinder():
            return Cylinder(pose, float(geometry.radius), 2.0 * float(geometry.halfLength), name)
        case pin.coal.Sphere():
            return Sphere(pose, float(geometry.radius), name)
        case pin.coal.ConvexBase():
            return Hull(pose, np.array(geometry.points()), name)
    kind = type(geometry).__name__
    raise ValueError(f"a collision body of link {name!r} is a {kind}; allowed: box, cylinder, sphere, mesh")


def read_mesh(path: str, scale: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> object:
    """Return the mesh of a file as a geometry of coal, the collision library; `scale` is a factor along each
    axis.

    Raises:
        ValueError: the file can't be read as a mesh.
    """
    try:
        return meshes().load(path, np.array(scale))
    except (RuntimeError, ValueError, TypeError) as error:
        said = " ".join(str(error).split()).rpartition(path)[2].partition("Hint:")[0]
        why = said.strip(' ."')[:_WORDS] or "no mesh is in it"
        raise ValueError(f"it can't be read: {why}; allowed: STL, OBJ or DAE") from None


def hull_of_mesh(mesh: object, name: str) -> object:
    """Return the convex hull of a mesh, both geometries of coal, the collision library.

    The error message names the mesh's link, `name`.

    Raises:
        ValueError: the mesh's vertices (fewer than four, all in a plane, or not finite) enclose nothing.
    """
    points = np.array(mesh.vertices())  # type: ignore[attr-defined]
    points = points - 0.0  # a copy of our own
    sound = len(points) >= _LEAST and bool(np.isfinite(points).all())
    if not sound or np.linalg.matrix_rank(points - points.mean(axis=0), tol=1e-7) < 3:
        raise ValueError(f"a mesh of link {name!r} encloses nothing; allowed: a closed surface")
    return _convex(points.tobytes(), len(points))


@lru_cache(maxsize=256)
def _convex(points: bytes, count: int) -> object:
    corners: FloatArray = np.frombuffer(points).reshape(count, 3)
    for item, how in (
        (corners, "Qt"),
        (corners, "QJ"),
        *((_thinned(corners, cells), "QJ") for cells in _CELLS),
    ):
        listed = pin.coal.StdVec_Vec3s()
        for corner in item:
            listed.append(corner)
        try:
            return pin.coal.Convex.convexHull(listed, True, how)
        except RuntimeError:
            continue
    raise ValueError("a mesh has no convex hull; allowed: a closed surface")


def _thinned(corners: FloatArray, cells: int) -> FloatArray:
    """Return one corner of each cell, because coal rejects corners with 256 neighbours, as on fine cones."""
    low, size = corners.min(axis=0), float(np.ptp(corners, axis=0).max())
    _, first = np.unique(np.floor(cells * (corners - low) / size), axis=0, return_index=True)
    return corners[np.sort(first)]
