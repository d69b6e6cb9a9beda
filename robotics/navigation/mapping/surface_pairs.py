"""Compiled loops of matching surfaces: pairs of nearest points, and the steps of the optimization."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.navigation.scans.scan_matching import wrapped
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled, compiled_for
from handcart.robotics.numerics.small_solve import solved

STEPS_PER_DISTANCE = 6
"""Number of optimization steps at each distance up to which points are paired."""
MIN_NORMAL_COSINE = 0.7
"""Minimum cosine of the angle between the normals of two partners."""
INLIER_M = 0.05
"""Distance in [m] to a partner's line within which a point counts as explained."""
MIN_SIGMA_M = 0.005
"""Lower limit in [m] of the residuals' sigma: surfaces are rough, and beams of one surface are correlated."""
DAMPING_INFORMATION = 1.0
"""Information in [1/m²] and [1/rad²] that keeps a pose in place where no surface determines it."""
CONVERGED_M, CONVERGED_RAD = 1e-4, 1e-4
"""Step of a pose below which an optimization ends."""

SortedSurface = tuple[FloatArray, FloatArray, int]
"""Points (m, 2) in [m], ascending along one axis; their unit normals (m, 2); that axis, 0 or 1."""
MovedSurface = tuple[FloatArray, FloatArray]
"""Points (n, 2) in [m], and their unit normals (n, 2)."""
SURFACE_TYPES = ("Tuple((f8[:,::1], f8[:,::1], i8))", "UniTuple(f8[:,::1], 2)")


@compiled_for((*SURFACE_TYPES, "f8[::1]", "f8[:,::1]", "f8[::1]"))
def fitted_pose(
    reference: SortedSurface, moved: MovedSurface, start: FloatArray, prior: FloatArray, gates: FloatArray
) -> FloatArray:
    """Return the pose (3,) at which one surface fits another best, by Gauss-Newton.

    Poses are of `moved` in the reference frame: x, y in [m] and heading in [rad]. The weights are those of
    Geman and McClure.

    Args:
        reference: surface to fit to.
        moved: surface in its own frame.
        start: (3,) pose at which the optimization begins, and which is expected.
        prior: (3, 3) information of `start`, x, y and heading in the reference frame, in [1/m²], [1/rad²].
        gates: (k,) distances in [m] up to which points are paired, one after the other.
    """
    pose, away = start.copy(), np.empty(3)
    hessian, gradient = np.empty((3, 3)), np.empty((3, 1))
    for gate in gates:
        scale = max(0.3 * gate, 2.0 * MIN_SIGMA_M)
        for _ in range(STEPS_PER_DISTANCE):
            _normal_equations(reference, moved, pose, (gate, scale), hessian, gradient)
            away[0], away[1] = pose[0] - start[0], pose[1] - start[1]
            away[2] = wrapped(pose[2] - start[2])
            for row in range(3):
                hessian[row, row] += DAMPING_INFORMATION
                for column in range(3):
                    hessian[row, column] += prior[row, column]
                    gradient[row, 0] += prior[row, column] * away[column]
            step = solved(hessian, gradient)
            pose[0], pose[1] = pose[0] - step[0, 0], pose[1] - step[1, 0]
            pose[2] = wrapped(pose[2] - step[2, 0])
            if abs(step[0, 0]) + abs(step[1, 0]) < CONVERGED_M and abs(step[2, 0]) < CONVERGED_RAD:
                break
    return pose


@compiled_for((*SURFACE_TYPES, "f8[::1]", "f8"))
def explained_points(
    reference: SortedSurface, moved: MovedSurface, pose: FloatArray, gate: float
) -> tuple[FloatArray, int, float]:
    """Return what the points that a surface explains say about the pose of another one.

    Args:
        reference: surface to which points are compared.
        moved: surface in its own frame.
        pose: (3,) pose of `moved` in the reference frame: x, y in [m], heading in [rad].
        gate: distance in [m] up to which points are paired.

    Returns:
        Sum (3, 3) of the products of the residuals' slopes by `pose`, number of explained points, and the
        sum of their squared residuals in [m²].
    """
    total, count, squares = np.zeros((3, 3)), 0, 0.0
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for index in range(len(moved[0])):
        found, slopes, residual = _residual(reference, moved, index, (pose[0], pose[1], cos, sin), gate)
        if found and abs(residual) < INLIER_M:
            count, squares = count + 1, squares + residual**2
            for row in range(3):
                for column in range(3):
                    total[row, column] += slopes[row] * slopes[column]
    return total, count, squares


@compiled
def _normal_equations(
    reference: SortedSurface,
    moved: MovedSurface,
    pose: FloatArray,
    gate_and_scale: tuple[float, float],
    hessian: FloatArray,
    gradient: FloatArray,
) -> None:
    """Compute the weighted squares of slopes (3, 3) and their products (3, 1) with residuals, in place."""
    gate, scale = gate_and_scale
    hessian[:], gradient[:] = 0.0, 0.0
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for index in range(len(moved[0])):
        found, slopes, residual = _residual(reference, moved, index, (pose[0], pose[1], cos, sin), gate)
        if found:
            weight = 1.0 / (scale * (1.0 + (residual / scale) ** 2)) ** 2
            for row in range(3):
                gradient[row, 0] += weight * slopes[row] * residual
                for column in range(3):
                    hessian[row, column] += weight * slopes[row] * slopes[column]


@compiled
def _residual(
    reference: SortedSurface,
    moved: MovedSurface,
    index: int,
    pose: tuple[float, float, float, float],
    gate: float,
) -> tuple[bool, tuple[float, float, float], float]:
    """Return whether a point has a partner, the slopes of its distance to the partner's line, and that
    distance.

    `pose` is x, y, and the cosine and sine of the heading.
    """
    lines, line_normals, axis = reference
    points, normals = moved
    arm_x = pose[2] * points[index, 0] - pose[3] * points[index, 1]
    arm_y = pose[3] * points[index, 0] + pose[2] * points[index, 1]
    x, y = pose[0] + arm_x, pose[1] + arm_y
    partner = _nearest(lines, axis, x, y, gate)
    if partner < 0:
        return False, (0.0, 0.0, 0.0), 0.0
    along, up = line_normals[partner, 0], line_normals[partner, 1]
    normal_x = pose[2] * normals[index, 0] - pose[3] * normals[index, 1]
    normal_y = pose[3] * normals[index, 0] + pose[2] * normals[index, 1]
    facing = normal_x * along + normal_y * up > MIN_NORMAL_COSINE
    residual = (x - lines[partner, 0]) * along + (y - lines[partner, 1]) * up
    return facing, (along, up, up * arm_x - along * arm_y), residual


@compiled
def _nearest(lines: FloatArray, axis: int, x: float, y: float, gate: float) -> int:
    """Return the index of the point nearest to (x, y), in [m]; -1 if none is nearer than `gate`.

    The search goes from (x, y) to both sides along the axis by which `lines` (m, 2) is sorted.
    """
    at = y if axis == 1 else x
    above = int(np.searchsorted(lines[:, axis], at))
    below, best, squared = above - 1, -1, gate * gate
    while above < len(lines) and (lines[above, axis] - at) ** 2 < squared:
        distance = (lines[above, 0] - x) ** 2 + (lines[above, 1] - y) ** 2
        if distance < squared:
            best, squared = above, distance
        above += 1
    while below >= 0 and (lines[below, axis] - at) ** 2 < squared:
        distance = (lines[below, 0] - x) ** 2 + (lines[below, 1] - y) ** 2
        if distance < squared:
            best, squared = below, distance
        below -= 1
    return best
