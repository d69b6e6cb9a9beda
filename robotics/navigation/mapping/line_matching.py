"""Matching of surfaces point to line (Censi, 2008), with robust weights."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray

from .scan_surface import Surface

GATES_M = (0.5, 0.3, 0.15, 0.1)
"""Distances in [m] up to which a point finds its partner, one after the other."""
STEPS_PER_DISTANCE = 6
"""Number of optimization steps at each distance of `GATES_M`."""
MIN_NORMAL_COSINE = 0.7
"""Minimum cosine of the angle between the normals of two partners."""
INLIER_M = 0.05
"""Distance in [m] to a partner's line within which a point counts as explained."""
MIN_SIGMA_M = 0.005
"""Lower limit in [m] of the residuals' sigma: surfaces are rough, and beams of one surface are correlated."""
CORRELATED_POINTS = 4.0
"""Number of points that count as one, because neighbours on a surface share its errors."""
BIAS_SHARE, BIAS_SHARE_RAD = 0.15, 0.05
"""Errors of a pose, in [m] and [rad] per metre of the residuals' sigma, that all points share."""
DAMPING_INFORMATION = np.diag([1.0, 1.0, 1.0])
"""Information (3, 3) that keeps a pose in place along directions that no surface determines."""


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
    trust = np.zeros((3, 3)) if prior is None else prior
    pose, hessian, sigma, inliers = start, np.zeros((3, 3)), MIN_SIGMA_M, 0.0
    if not len(reference.points) or not len(moved.points):
        return LineMatch(start, trust, 0.0, math.inf)
    for gate in gates:
        scale = max(0.3 * gate, 2.0 * MIN_SIGMA_M)
        for _ in range(STEPS_PER_DISTANCE):
            slopes, residuals, weights = _pairs(reference, moved, pose, gate, scale)
            weighted = slopes * weights[:, None] / scale**2
            hessian, gradient = weighted.T @ slopes, weighted.T @ residuals
            away = np.array([pose.x - start.x, pose.y - start.y, wrap(pose.theta - start.theta)])
            step = np.linalg.solve(hessian + trust + DAMPING_INFORMATION, gradient + trust @ away)
            pose = Pose2(pose.x - step[0], pose.y - step[1], wrap(pose.theta - step[2]))
            if abs(step[0]) + abs(step[1]) < 1e-4 and abs(step[2]) < 1e-4:
                break
    slopes, residuals, _ = _pairs(reference, moved, pose, gates[-1], 1.0)
    good = np.abs(residuals) < INLIER_M
    inliers = float(np.count_nonzero(good)) / len(moved.points)
    sigma = max(MIN_SIGMA_M, float(np.sqrt(np.mean(residuals[good] ** 2)))) if good.any() else math.inf
    if not good.any():
        return LineMatch(pose, trust, 0.0, math.inf)
    hessian = slopes[good].T @ slopes[good] / (CORRELATED_POINTS * sigma**2)
    return LineMatch(pose, _limited(hessian, sigma) + trust, inliers, sigma)


def _limited(information: FloatArray, sigma: float) -> FloatArray:
    """Return the information (3, 3) after adding the errors that no number of points averages away."""
    place, heading = (BIAS_SHARE * sigma) ** -2, (BIAS_SHARE_RAD * sigma) ** -2
    floor = np.diag([place, place, heading])
    # The sum of two covariances by their informations; the first may be singular.
    found: FloatArray = floor - floor @ np.linalg.solve(information + floor, floor)
    return 0.5 * (found + found.T)


def _pairs(
    reference: Surface, moved: Surface, pose: Pose2, gate: float, scale: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return slopes (n, 3), residuals (n,) in [m] and weights (n,) of the points that have a partner.

    Slopes are those of the residuals by x, y in [m] and heading in [rad] of `pose`.
    """
    here = pose.apply(moved.points)
    normals = Pose2(0.0, 0.0, pose.theta).apply(moved.normals)
    distances, partners = reference.tree.query(here, distance_upper_bound=gate)
    found = np.isfinite(distances)
    partners = partners[found]
    facing = (normals[found] * reference.normals[partners]).sum(axis=1) > MIN_NORMAL_COSINE
    here, partners = here[found][facing], partners[facing]
    normal = reference.normals[partners]
    residuals = ((here - reference.points[partners]) * normal).sum(axis=1)
    arm = here - (pose.x, pose.y)
    turning = normal[:, 1] * arm[:, 0] - normal[:, 0] * arm[:, 1]
    weights = 1.0 / (1.0 + (residuals / scale) ** 2) ** 2  # Geman and McClure
    return np.column_stack([normal, turning]), residuals, weights
