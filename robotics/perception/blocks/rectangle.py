"""A rectangle in a plane, and lines across its edges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

OUTWARD_NORMALS: FloatArray = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""Outward unit normals (4, 2) of the edges at +x, +y, -x and -y, the order of edges everywhere."""
EDGE_DIRECTIONS: FloatArray = np.array([[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]])
AXIS, OTHER = np.array([0, 1, 0, 1]), np.array([1, 0, 1, 0])
"""Axis (0 is x, 1 is y) at right angles to each edge, and axis along it."""
_ENDS = 0.08  # of an edge that is skipped at each end: the blurred corners


class Rectangle(NamedTuple):
    """Rectangle in a plane, such as a face of a block; its pose is plane_T_centre, with x along its
    length.
    """

    pose: Pose2
    half: FloatArray
    """(2,) half of its length (along x) and width, in [m]."""
    seen: BoolArray
    """(4,) True for edges that were found, in the order +x, +y, -x, -y."""


def shares(count: int) -> FloatArray:
    """Return `count` evenly spaced places along an edge, (count,), as shares of half its length.

    0 is the middle of the edge. The first and last places are a little inside its ends, -1 and 1.
    """
    return np.linspace(-1.0, 1.0, count) * (1.0 - 2 * _ENDS)


def across(
    half: FloatArray, share: FloatArray, inner: FloatArray, outer: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the ends of short lines that cross a rectangle's edges at right angles, to search the edges
    along them.

    Args:
        half: (2,) half length and half width of the rectangle, in [m].
        share: (n,) places of the lines along each edge, from -1 to 1 at its ends.
        inner: (4,) distance of the first points outwards from each edge, in [m]; negative inside.
        outer: (4,) distance of the last points outwards from each edge, in [m].

    Returns:
        Two arrays (4, n, 2) in the rectangle's frame, in [m], with the edges at +x, +y, -x and -y.
    """
    along = (half[OTHER, None] * share)[..., None] * EDGE_DIRECTIONS[:, None]
    first, last = (
        ((half[AXIS] + item)[:, None] * OUTWARD_NORMALS)[:, None] + along for item in (inner, outer)
    )
    return first, last
