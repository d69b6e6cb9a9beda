"""Nearest trackable position to a point that can't be tracked."""

from __future__ import annotations

from itertools import product

import numpy as np

from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .placement_refinement import Scorer

_SHELLS = 0.01 * 1.5 ** np.arange(20)  # [m] 10 mm to 22 m
_FINEST = 0.001  # [m]


def with_nearest(error: Untrackable, scorer: Scorer, path: ToolPath, bases: FloatArray) -> Untrackable:
    """Return an error for an unreachable point, completed by the nearest position that some base pose can
    track.

    The point is moved by up to 22 m in each of 26 directions, until the arm reaches it from some base pose.
    The distance is then found to a millimetre. The tool's rotation and the tangent are unchanged. "Nearest"
    is only among these directions. The position is None if the arm reaches none of the moved points.

    Args:
        error: error that names the point that can't be tracked.
        scorer: returns the scores of base poses.
        path: path of the tool in the world.
        bases: (b, 3) world_T_base: x, y in [m], heading in [rad].
    """
    return Untrackable(error.index, error.why, _nearest(scorer, path, bases, error.index))


def _nearest(scorer: Scorer, path: ToolPath, bases: FloatArray, index: int) -> FloatArray | None:
    directions = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    inner = 0.0
    for outer in _SHELLS:
        found = _usable(scorer, path, bases, index, outer * directions)
        if found.any():
            offset = _pull_in(scorer, path, bases, index, directions[found], inner, float(outer))
            return np.asarray(path.points[index] + offset)
        inner = float(outer)
    return None


def _pull_in(
    scorer: Scorer,
    path: ToolPath,
    bases: FloatArray,
    index: int,
    directions: FloatArray,
    inner: float,
    outer: float,
) -> FloatArray:
    """Return the shortest offset (3,), in [m], along `directions` (m, 3) between two distances, halving."""
    while outer - inner > _FINEST:
        middle = 0.5 * (inner + outer)
        found = _usable(scorer, path, bases, index, middle * directions)
        if found.any():
            directions, outer = directions[found], middle
        else:
            inner = middle
    return np.asarray(outer * directions[0])


def _usable(scorer: Scorer, path: ToolPath, bases: FloatArray, index: int, offsets: FloatArray) -> BoolArray:
    """(m,): whether the point moved by offsets (m, 3) in [m] can be used from any base."""
    rows = np.full(len(offsets), index)
    moved = ToolPath(*(field[rows] for field in path))._replace(points=path.points[index] + offsets)
    return np.asarray(scorer(bases, moved).usable.any(axis=0))
