"""Kinematics of a `ScrewChain`, compiled: forward, Jacobian, and a descent to a tool pose.

A task may leave one turn of the tool free: about the vertical of the base (an arm without wrist yaw), or
about the tool's own x axis (a tool that is round).
"""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled, compiled_for

from .screw_chain import CHAIN_TYPES, POSTURE_TYPES, ChainPosture, ScrewChain

NOTHING_FREE = 0
VERTICAL_FREE = 1
TOOL_FREE = 2

_TOLERANCE = 1e-8  # [m] and [rad]
_DAMPING = 1e-9
_LONGEST_STEP = 0.5  # [rad]


@compiled
def turn_matrix(axis: FloatArray, angle: float, out: FloatArray) -> None:
    """Write the rotation around an axis into `out`, by Rodrigues' formula.

    Args:
        axis: (3,) unit vector in any frame.
        angle: angle of the rotation, in [rad].
        out: (3, 3) in the same frame, written.
    """
    s, c = math.sin(angle), math.cos(angle)
    d = 1.0 - c
    x, y, z = axis[0], axis[1], axis[2]
    out[0, 0], out[0, 1], out[0, 2] = c + d * x * x, d * x * y - s * z, d * x * z + s * y
    out[1, 0], out[1, 1], out[1, 2] = d * x * y + s * z, c + d * y * y, d * y * z - s * x
    out[2, 0], out[2, 1], out[2, 2] = d * x * z - s * y, d * y * z + s * x, c + d * z * z


@compiled
def _times(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@compiled
def tip_and_jacobian(chain: ScrewChain, posture: ChainPosture) -> None:
    """Compute the tip's pose and Jacobian at the joint angles of a posture, and write them into the
    posture.
    """
    axes, points, tip = chain.axes, chain.points, chain.base_T_tip
    q, pose, jacobian = posture.q, posture.pose, posture.jacobian
    n = len(q)
    turned, step, product = np.eye(3), np.empty((3, 3)), np.empty((3, 3))
    moved, offset = np.zeros(3), np.empty(3)
    where = np.empty((n, 3))
    for i in range(n):
        for r in range(3):
            jacobian[3 + r, i] = (
                turned[r, 0] * axes[i, 0] + turned[r, 1] * axes[i, 1] + turned[r, 2] * axes[i, 2]
            )
            where[i, r] = moved[r]
            for c in range(3):
                where[i, r] += turned[r, c] * points[i, c]
        turn_matrix(axes[i], q[i], step)
        _times(turned, step, product)
        turned, product = product, turned
        for r in range(3):
            offset[r] = where[i, r]
            for c in range(3):
                offset[r] -= turned[r, c] * points[i, c]
        moved, offset = offset, moved
    for r in range(3):
        pose[r, 3] = moved[r]
        for c in range(3):
            pose[r, 3] += turned[r, c] * tip[c, 3]
            pose[r, c] = turned[r, 0] * tip[0, c] + turned[r, 1] * tip[1, c] + turned[r, 2] * tip[2, c]
    for i in range(n):
        x, y, z = pose[0, 3] - where[i, 0], pose[1, 3] - where[i, 1], pose[2, 3] - where[i, 2]
        a, b, c = jacobian[3, i], jacobian[4, i], jacobian[5, i]
        jacobian[0, i], jacobian[1, i], jacobian[2, i] = b * z - c * y, c * x - a * z, a * y - b * x


@compiled
def pose_error(pose: FloatArray, target: FloatArray, free: int, error: FloatArray) -> None:
    """Write the motion from a pose to a target into `error`, without the rotation about the axis that is
    free.

    Args:
        pose: (4, 4) base_T_tip.
        target: (4, 4) wanted base_T_tip.
        free: 1 if the azimuth about the z of the base is free, 2 if the turn about the x of the tool is free,
            0 if neither is.
        error: (6,), written: target minus pose in [m], and the rotation vector that turns the pose into
            the target in [rad], in the axes of the base.
    """
    goal = target[:3, :3].copy()
    if free == 1:
        across = along = 0.0
        for c in range(3):
            across += pose[1, c] * target[0, c] - pose[0, c] * target[1, c]
            along += pose[0, c] * target[0, c] + pose[1, c] * target[1, c]
        size = math.hypot(across, along)
        if size > 0.0:
            s, k = across / size, along / size
            for c in range(3):
                goal[0, c] = k * target[0, c] - s * target[1, c]
                goal[1, c] = s * target[0, c] + k * target[1, c]
    elif free == 2:
        across = along = 0.0
        for r in range(3):
            across += target[r, 2] * pose[r, 1] - target[r, 1] * pose[r, 2]
            along += target[r, 1] * pose[r, 1] + target[r, 2] * pose[r, 2]
        size = math.hypot(across, along)
        if size > 0.0:
            s, k = across / size, along / size
            for r in range(3):
                goal[r, 1] = k * target[r, 1] + s * target[r, 2]
                goal[r, 2] = k * target[r, 2] - s * target[r, 1]
    turn = np.empty((3, 3))
    for i in range(3):
        error[i] = target[i, 3] - pose[i, 3]
        for j in range(3):
            turn[i, j] = goal[i, 0] * pose[j, 0] + goal[i, 1] * pose[j, 1] + goal[i, 2] * pose[j, 2]
    x, y, z = turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    factor = 0.5 if sine < 1e-9 else 0.5 * angle / sine
    error[3], error[4], error[5] = factor * x, factor * y, factor * z


@compiled
def without_free(pose: FloatArray, free: int, rows: FloatArray) -> None:
    """Remove the rotation about the axis that the task leaves free from a Jacobian's columns or from a twist.

    The array is changed in place.

    Args:
        pose: (4, 4) base_T_tip.
        free: 1 if the azimuth about the z of the base is free, 2 if the turn about the x of the tool is free,
            0 if neither is.
        rows: (6, k) in the axes of the base: three rows of translation in [m], three of rotation in [rad];
            overwritten.
    """
    if free == 0:
        return
    x, y, z = (0.0, 0.0, 1.0) if free == 1 else (pose[0, 0], pose[1, 0], pose[2, 0])
    for i in range(rows.shape[1]):
        along = x * rows[3, i] + y * rows[4, i] + z * rows[5, i]
        rows[3, i] -= along * x
        rows[4, i] -= along * y
        rows[5, i] -= along * z


@compiled
def determinant_in_place(matrix: FloatArray) -> float:
    """Return the determinant of a small square matrix (n, n), by Gaussian elimination with row pivots.

    The matrix, in any units, is overwritten. `numpy.linalg.det` is not used because numba takes a second to
    compile it.
    """
    n, product = len(matrix), 1.0
    for column in range(n):
        pivot = column
        for row in range(column + 1, n):
            if abs(matrix[row, column]) > abs(matrix[pivot, column]):
                pivot = row
        if matrix[pivot, column] == 0.0:
            return 0.0
        if pivot != column:
            product = -product
            for other in range(column, n):
                matrix[column, other], matrix[pivot, other] = matrix[pivot, other], matrix[column, other]
        product *= matrix[column, column]
        for row in range(column + 1, n):
            factor = matrix[row, column] / matrix[column, column]
            for other in range(column, n):
                matrix[row, other] -= factor * matrix[column, other]
    return product


@compiled
def solve_in_place(matrix: FloatArray, right: FloatArray) -> bool:
    """Solve a small system of linear equations by Gauss's elimination with pivots; return False if singular.

    Args:
        matrix: (n, n) in any units; overwritten.
        right: (n,) right-hand side; the solution is written into it.
    """
    n = len(right)
    for column in range(n):
        pivot = column
        for row in range(column + 1, n):
            if abs(matrix[row, column]) > abs(matrix[pivot, column]):
                pivot = row
        if abs(matrix[pivot, column]) < 1e-14:
            return False
        if pivot != column:
            for other in range(n):
                matrix[column, other], matrix[pivot, other] = matrix[pivot, other], matrix[column, other]
            right[column], right[pivot] = right[pivot], right[column]
        for row in range(column + 1, n):
            factor = matrix[row, column] / matrix[column, column]
            for other in range(column, n):
                matrix[row, other] -= factor * matrix[column, other]
            right[row] -= factor * right[column]
    for row in range(n - 1, -1, -1):
        for other in range(row + 1, n):
            right[row] -= matrix[row, other] * right[other]
        right[row] /= matrix[row, row]
    return True


@compiled_for((CHAIN_TYPES, "f8[:,::1]", "i8", "i8", POSTURE_TYPES))
def descend(chain: ScrewChain, target: FloatArray, free: int, iterations: int, posture: ChainPosture) -> bool:
    """Move an arm's joints to a pose by damped least squares, within their limits; return whether that
    succeeded.

    Args:
        chain: kinematics of the arm.
        target: (4, 4) wanted base_T_tip.
        free: 1 if the azimuth about the z of the base is free, 2 if the turn about the x of the tool is free,
            0 if neither is.
        iterations: largest number of steps.
        posture: posture whose angles are the start, in [rad]; the result is written into it.
    """
    q, pose, lower, upper = posture.q, posture.pose, chain.lower, chain.upper
    n = len(q)
    error, matrix, right = np.empty((6, 1)), np.empty((n, n)), np.empty(n)
    for _ in range(iterations):
        tip_and_jacobian(chain, posture)
        pose_error(pose, target, free, error[:, 0])
        squared = 0.0
        for r in range(6):
            squared += error[r, 0] * error[r, 0]
        if squared < _TOLERANCE * _TOLERANCE:
            return True
        reduced = posture.jacobian.copy()
        without_free(pose, free, reduced)
        without_free(pose, free, error)
        for i in range(n):
            right[i] = 0.0
            for r in range(6):
                right[i] += reduced[r, i] * error[r, 0]
        for i in range(n):
            if (q[i] <= lower[i] and right[i] < 0.0) or (q[i] >= upper[i] and right[i] > 0.0):
                right[i] = 0.0
                reduced[:, i] = 0.0
        for i in range(n):
            for j in range(n):
                matrix[i, j] = 0.0
                for r in range(6):
                    matrix[i, j] += reduced[r, i] * reduced[r, j]
            matrix[i, i] += _DAMPING + 0.05 * squared
        if not solve_in_place(matrix, right):
            return False
        longest = 0.0
        for i in range(n):
            longest = max(longest, abs(right[i]))
        if longest == 0.0:
            return False
        scale = min(1.0, _LONGEST_STEP / longest)
        for i in range(n):
            q[i] = min(max(q[i] + scale * right[i], lower[i]), upper[i])
    return False
