"""Ability of an arm to move and push along a path: Shin (2005), with its flaws corrected.

All functions take Jacobians (..., m, n) and directions (..., m) with any leading axes; m is 2 for an arm
in a plane, 6 for tool poses. The direction is the tool's motion for each metre of path
(`ToolPath.twists`): a unit tangent, and the turn that goes with it.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from scipy.optimize import linprog

from handcart.robotics.numerics.arrays import FloatArray

_RANK = 1e-10  # of the largest singular value


def directional(jacobian: FloatArray, direction: FloatArray) -> FloatArray:
    """|k^T J| (..., n), in [m] for a revolute joint: Shin (2005), eq. 4, absolute values.

    Velocity side: how fast the tool moves along k for each rad/s of a joint, whatever else it does. Force
    side: the torque of each joint for a newton along k (eq. 5); the weight of the arm isn't in it.
    """
    return np.asarray(np.abs(np.einsum("...m,...mn->...n", direction, jacobian)))


def manipulability(jacobian: FloatArray) -> FloatArray:
    """sqrt(det(J J^T)) (...): Yoshikawa (1985); eq. 2 of Shin (2005)."""
    squared = np.linalg.det(jacobian @ np.swapaxes(jacobian, -1, -2))
    return np.asarray(np.sqrt(np.maximum(squared, 0.0)))


def top_speed(jacobian: FloatArray, direction: FloatArray, velocity: FloatArray) -> FloatArray:
    """Return the highest speed (...) along a path that the joints allow, in [m/s]: the largest v with J qd =
    v k.

    k^T J says nothing about directions across k: it can be large where no motion along k exists. This is
    the exact condition. For a square J and equal limits of 1 rad/s it is 1 / max|J^-1 k|.

    With redundant joints, v is where the ray along k leaves the image of the box of joint speeds (a
    zonotope). Each of its faces is spanned by m-1 columns of J; the normals of all of them give v in
    closed form. Where J has lost rank the linear program is solved instead.

    Args:
        jacobian: (..., m, n) Jacobians J of the tool's velocity.
        direction: (..., m) unit vectors k along the path.
        velocity: joint speed limits (n,), in [rad/s].
    """
    m, n = jacobian.shape[-2:]
    lead = np.broadcast_shapes(jacobian.shape[:-2], direction.shape[:-1])
    J = np.broadcast_to(jacobian, (*lead, m, n)).reshape(-1, m, n)
    k = np.broadcast_to(direction, (*lead, m)).reshape(-1, m)
    singular_values = np.linalg.svd(J, compute_uv=False)
    full = singular_values[:, min(m, n) - 1] > _RANK * np.maximum(singular_values[:, 0], _RANK)
    full &= n >= m
    speed = np.empty(len(J))
    speed[full] = _square(J[full], k[full], velocity) if n == m else _zonotope(J[full], k[full], velocity)
    for index in np.flatnonzero(~full):
        speed[index] = top_speed_by_program(J[index], k[index], velocity)
    return speed.reshape(lead)


def top_speed_by_program(jacobian: FloatArray, direction: FloatArray, velocity: FloatArray) -> float:
    """Return the top speed for one Jacobian (m, n) of any rank by linear programming (HiGHS), in [m/s]."""
    n = jacobian.shape[1]
    objective = np.append(np.zeros(n), -1.0)
    equal = np.column_stack((jacobian, -direction))
    bounds = [*((-limit, limit) for limit in velocity), (0.0, None)]
    found = linprog(objective, A_eq=equal, b_eq=np.zeros(len(direction)), bounds=bounds, method="highs")
    if found.status == 3:
        return np.inf
    if found.status != 0:
        raise RuntimeError(f"HiGHS found no top speed: {found.message}")
    return float(found.x[-1])


def _square(J: FloatArray, k: FloatArray, velocity: FloatArray) -> FloatArray:
    rates = np.linalg.solve(J, k[..., None])[..., 0]
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / np.max(np.abs(rates) / velocity, axis=-1))


def _zonotope(J: FloatArray, k: FloatArray, velocity: FloatArray) -> FloatArray:
    m, n = J.shape[-2:]
    speed = np.full(len(J), np.inf)
    if len(J) == 0:
        return speed
    for columns in combinations(range(n), m - 1):
        normal = _normal(J[:, :, columns])
        along = np.abs(np.einsum("bm,bm->b", normal, k))
        far = np.abs(np.einsum("bm,bmn->bn", normal, J)) @ velocity
        crossed = along > _RANK * np.linalg.norm(normal, axis=1) * np.linalg.norm(k, axis=1)
        crossed &= np.linalg.norm(normal, axis=1) > 0.0
        speed[crossed] = np.minimum(speed[crossed], far[crossed] / along[crossed])
    return speed


def _normal(columns: FloatArray) -> FloatArray:
    """Return (b, m) across m-1 columns (b, m, m-1); zero where these depend on each other."""
    m = columns.shape[1]
    if m == 3:
        return np.cross(columns[:, :, 0], columns[:, :, 1])
    sides = [np.delete(columns, row, axis=1) for row in range(m)]
    signs = (-1.0) ** np.arange(m)
    return np.asarray(np.stack([np.linalg.det(side) for side in sides], axis=1) * signs)
