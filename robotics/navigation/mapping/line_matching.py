"""Matching of surfaces point to line (Censi, 2008), with robust weights."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .scan_surface import Surface
from .surface_pairs import MIN_SIGMA_M, explained_points, fitted_pose

GATES_M = (0.5, 0.3, 0.15, 0.1)
"""Distances in [m] up to which a point finds its partner, one after the other."""
CORRELATED_POINTS = 4.0
"""Number of points that count as one, because neighbours on a surface share its errors."""
BIAS_SHARE, BIAS_SHARE_RAD = 0.15, 0.05
"""Errors of a pose, in [m] and [rad] per metre of the residuals' sigma, that all points share."""


class LineMatch(NamedTuple):
    """Result of fitting lidar points to reference points: their relative pose, its information matrix,
    quality.
    """

    pose: Pose2
    """reference_T_moved."""
    information: FloatArray
    """(3, 3) of x, y and heading in the reference frame, in [1/m²] and [1/rad²]; singular in a corridor."""
    inliers: float
    """Share of the points that the reference explains, 0 to 1."""
    sigma: float
    """Standard deviation of the residuals of the explained points, in [m]; infinite if none is explained."""


def match_surfaces(
    reference: Surface,
    moved: Surface,
    start: Pose2,
    prior: FloatArray | None = None,
    gates: tuple[float, ...] = GATES_M,
) -> LineMatch:
    """Return the pose near `start` at which the surface `moved` fits the surface `reference` best.

    Args:
        reference: surface to fit to.
        moved: surface whose pose in the reference frame is sought.
        start: estimated reference_T_moved.
        prior: (3, 3) information matrix of `start`, x, y and heading in the reference frame, in [1/m²] and
            [1/rad²], also added to that of the result; None for an unknown start.
        gates: decreasing distances, in [m], up to which points of both surfaces are paired.
    """
    trust = np.zeros((3, 3)) if prior is None else np.ascontiguousarray(prior, dtype=np.float64)
    if not len(reference.points) or not len(moved.points):
        return LineMatch(start, trust, 0.0, math.inf)
    surfaces = reference.sorted, (moved.points, moved.normals)
    pose = fitted_pose(*surfaces, np.array(start, dtype=np.float64), trust, np.array(gates))
    found, count, squares = explained_points(*surfaces, pose, gates[-1])
    fitted = Pose2(*pose.tolist())
    if not count:
        return LineMatch(fitted, trust, 0.0, math.inf)
    sigma = max(MIN_SIGMA_M, math.sqrt(squares / count))
    information = _limited(found / (CORRELATED_POINTS * sigma**2), sigma)
    return LineMatch(fitted, information + trust, count / len(moved.points), sigma)


def _limited(information: FloatArray, sigma: float) -> FloatArray:
    """Return the information (3, 3) after adding the errors that no number of points averages away."""
    place, heading = (BIAS_SHARE * sigma) ** -2, (BIAS_SHARE_RAD * sigma) ** -2
    floor = np.diag([place, place, heading])
    # The sum of two covariances by their informations; the first may be singular.
    found: FloatArray = floor - floor @ np.linalg.solve(information + floor, floor)
    return 0.5 * (found + found.T)
