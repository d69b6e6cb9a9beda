"""Pose graph in the plane: sparse Gauss-Newton with weights that switch wrong loop closures off.

Errors and Jacobians are those of Grisetti et al. (2010), eq. 30 to 33; the weights of loop closures are those
of dynamic covariance scaling (Agarwal et al., 2013, eq. 15).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

MAX_STEPS = 60
SMALL_STEP = 1e-6
"""Step in [m] or [rad] at which the optimization has converged."""
ANCHOR_INFORMATION = np.diag([1e8, 1e8, 1e8])
"""Information (3, 3) of the first pose, which stays where it is."""
SCALING_CHI2 = 7.8
"""Squared error in sigmas up to which an edge has its full weight: 95 % of right ones are below."""
GRADUATED_CHI2 = (1e4, 1e3, 1e2, SCALING_CHI2)
"""Values of `SCALING_CHI2` that are used in turn if initial poses are far from the solution (Yang et al.,
2020).
"""
COLUMNS_AT_ONCE = 300
"""Columns of a covariance that are computed together."""


class Edge(NamedTuple):
    """Edge of a pose graph, the measured pose of one node, such as a keyframe, in the frame of another."""

    first: int
    """Number of the node in whose frame the other one was measured."""
    second: int
    """Number of the measured node."""
    pose: Pose2
    """first_T_second."""
    information: FloatArray
    """(3, 3) in the frame of the first node, in [1/m², 1/m rad, 1/rad²]."""
    is_loop: bool = False
    """True if the edge closes a loop, and may be wrong."""


class _Edges(NamedTuple):
    """All edges as arrays."""

    first: IntArray
    second: IntArray
    poses: FloatArray
    information: FloatArray
    is_loop: BoolArray


def optimize(poses: FloatArray, edges: list[Edge], robust: bool = True) -> FloatArray:
    """Return the most likely poses (n, 3) of a graph's nodes, given its edges; the first pose stays
    unchanged.

    The result has the frame and units of `poses`.

    Args:
        poses: (n, 3) x, y in [m], heading in [rad], of each node in the graph's frame, near the solution.
        edges: measured relative poses; each node is reached from the first one.
        robust: True to reduce the weight of loop closures that contradict the other edges.
    """
    table = _arrays(edges)
    for limit in GRADUATED_CHI2 if robust else (math.inf,):
        poses = _descend(poses, table, limit)
    return poses


def _descend(poses: FloatArray, table: _Edges, limit: float) -> FloatArray:
    """Return the poses (n, 3) after Levenberg-Marquardt at one limit of the squared errors, in sigmas."""
    from scipy.sparse.linalg import splu

    damping, cost = 1e-6, _cost(poses, table, limit)
    for _ in range(MAX_STEPS):
        hessian, gradient = _normal_equations(poses, table, limit)
        diagonal = hessian.diagonal()
        step = splu((hessian + _diagonal(damping * diagonal)).tocsc()).solve(-gradient).reshape(-1, 3)
        tried = poses + step
        tried[:, 2] = _wrapped(tried[:, 2])
        new_cost = _cost(tried, table, limit)
        if new_cost > cost * (1.0 + 1e-9):
            damping *= 10.0
            if damping > 1e6:
                break
            continue
        poses, cost, damping = tried, new_cost, max(damping / 10.0, 1e-9)
        if np.abs(step).max() < SMALL_STEP:
            break
    return poses


def edge_errors(poses: FloatArray, edges: list[Edge]) -> FloatArray:
    """Return the squared error (m,) of each edge of a pose graph, as a squared Mahalanobis distance, without
    unit.

    Args:
        poses: (n, 3) of the nodes in the graph's frame: x, y in [m], heading in [rad].
        edges: measured relative poses.
    """
    if not edges:
        return np.empty(0)
    table = _arrays(edges)
    errors = _errors(poses, table)
    chi2: FloatArray = np.einsum("ni,nij,nj->n", errors, table.information, errors)
    return chi2


def covariances(poses: FloatArray, edges: list[Edge]) -> FloatArray:
    """Return the covariance (n, 3, 3) of each pose relative to the first one, in the graph's frame.

    Rows are x, y in [m] and heading in [rad].

    Args:
        poses: (n, 3) of the nodes in the graph's frame: x, y in [m], heading in [rad].
        edges: measured relative poses.
    """
    factor = factorized(poses, edges)
    count = 3 * len(poses)
    found = np.empty((len(poses), 3, 3))
    for low in range(0, count, COLUMNS_AT_ONCE):
        high = min(count, low + COLUMNS_AT_ONCE)
        unit = np.zeros((count, high - low))
        unit[np.arange(low, high), np.arange(high - low)] = 1.0
        columns = factor.solve(unit)
        for node in range(low // 3, high // 3):
            found[node] = columns[3 * node : 3 * node + 3, 3 * node - low : 3 * node + 3 - low]
    return 0.5 * (found + found.transpose(0, 2, 1))


def factorized(poses: FloatArray, edges: list[Edge]) -> Any:
    """Return the factorized information matrix (3n, 3n), in [1/m²] and [1/rad²].

    Its rows are x, y and heading of each pose in the graph's frame. The `solve` method of the
    result returns columns of the covariance.

    Args:
        poses: (n, 3) of the nodes in the graph's frame: x, y in [m], heading in [rad].
        edges: measured relative poses.
    """
    from scipy.sparse.linalg import splu

    return splu(_normal_equations(poses, _arrays(edges), SCALING_CHI2)[0].tocsc())


def relative_covariances(factor: Any, poses: FloatArray, node: int, diagonal: FloatArray) -> FloatArray:
    """Return the covariance (n, 3, 3) of each pose relative to one node, in the graph's frame.

    Rows are x, y in [m] and heading in [rad].

    Args:
        factor: factorized information matrix (3n, 3n) of all poses, returned by `factorized`.
        poses: (n, 3) of the nodes in the graph's frame: x, y in [m], heading in [rad].
        node: number of the node that the others are relative to.
        diagonal: (n, 3, 3) covariance of each pose relative to the first one.
    """
    unit = np.zeros((3 * len(poses), 3))
    unit[3 * node : 3 * node + 3] = np.eye(3)
    cross = factor.solve(unit).reshape(-1, 3, 3)  # of each pose with the node
    turn = np.tile(np.eye(3), (len(poses), 1, 1))  # how a turn of the node moves the others
    turn[:, 0, 2] = -(poses[:, 1] - poses[node, 1])
    turn[:, 1, 2] = poses[:, 0] - poses[node, 0]
    moved = cross @ turn.transpose(0, 2, 1)
    found: FloatArray = (
        diagonal - moved - moved.transpose(0, 2, 1) + turn @ diagonal[node] @ turn.transpose(0, 2, 1)
    )
    return found


def _arrays(edges: list[Edge]) -> _Edges:
    return _Edges(
        np.array([edge.first for edge in edges], dtype=np.int64),
        np.array([edge.second for edge in edges], dtype=np.int64),
        np.array([edge.pose for edge in edges]).reshape(-1, 3),
        np.array([edge.information for edge in edges]).reshape(-1, 3, 3),
        np.array([edge.is_loop for edge in edges], dtype=np.bool_),
    )


def _wrapped(angles: FloatArray) -> FloatArray:
    wrapped: FloatArray = np.arctan2(np.sin(angles), np.cos(angles))
    return wrapped


def _errors(poses: FloatArray, edges: _Edges) -> FloatArray:
    """Return the error (m, 3) of each edge, poses less measurement, in the frame of its first node."""
    one, other = poses[edges.first], poses[edges.second]
    cos, sin = np.cos(one[:, 2]), np.sin(one[:, 2])
    x, y = (other - one)[:, 0], (other - one)[:, 1]
    errors: FloatArray = np.column_stack(
        [
            cos * x + sin * y - edges.poses[:, 0],
            -sin * x + cos * y - edges.poses[:, 1],
            _wrapped(other[:, 2] - one[:, 2] - edges.poses[:, 2]),
        ]
    )
    return errors


def _scales(chi2: FloatArray, is_loop: BoolArray, limit: float) -> FloatArray:
    """Return the factor (m,) of each edge's information.

    A closure may be wrong (dynamic covariance scaling); the motion between neighbours may be far off, but no
    edge could replace it (Huber).
    """
    loops = np.minimum(1.0, 2.0 * limit / (limit + chi2)) ** 2
    weights: FloatArray = np.where(is_loop, loops, np.minimum(1.0, np.sqrt(limit / np.maximum(chi2, 1e-12))))
    return weights


def _cost(poses: FloatArray, edges: _Edges, limit: float) -> float:
    errors = _errors(poses, edges)
    chi2 = np.einsum("ni,nij,nj->n", errors, edges.information, errors)
    if math.isinf(limit):
        return float(chi2.sum())
    scale = np.minimum(1.0, 2.0 * limit / (limit + chi2))
    loops = scale**2 * chi2 + limit * (1.0 - scale) ** 2
    motions = np.where(chi2 <= limit, chi2, 2.0 * np.sqrt(limit * chi2) - limit)
    return float(np.where(edges.is_loop, loops, motions).sum())


def _normal_equations(poses: FloatArray, edges: _Edges, limit: float) -> tuple[Any, FloatArray]:
    """Return the Hessian (3n, 3n), sparse, and the gradient (3n,)."""
    from scipy.sparse import coo_matrix

    errors = _errors(poses, edges)
    information = edges.information
    if math.isfinite(limit):
        chi2 = np.einsum("ni,nij,nj->n", errors, information, errors)
        information = information * _scales(chi2, edges.is_loop, limit)[:, None, None]
    ends = edges.first, edges.second
    slopes = _jacobians(poses, edges)
    gradient = np.zeros((len(poses), 3))
    rows, columns, values = [], [], []
    local = np.arange(3)
    for node, slope in zip(ends, slopes, strict=True):
        leaned = slope.transpose(0, 2, 1) @ information
        np.add.at(gradient, node, (leaned @ errors[..., None])[..., 0])
        for other, slope_of_other in zip(ends, slopes, strict=True):
            block = leaned @ slope_of_other
            rows.append(np.broadcast_to(3 * node[:, None, None] + local[:, None], block.shape).ravel())
            columns.append(np.broadcast_to(3 * other[:, None, None] + local, block.shape).ravel())
            values.append(block.ravel())
    rows.append(np.repeat(local, 3))
    columns.append(np.tile(local, 3))
    values.append(ANCHOR_INFORMATION.ravel())
    shape = (3 * len(poses), 3 * len(poses))
    indices = np.concatenate(rows), np.concatenate(columns)
    return coo_matrix((np.concatenate(values), indices), shape=shape).tocsc(), gradient.ravel()


def _jacobians(poses: FloatArray, edges: _Edges) -> tuple[FloatArray, FloatArray]:
    """Return the slopes (m, 3, 3) of each error along the first and the second node's pose."""
    one, other = poses[edges.first], poses[edges.second]
    cos, sin = np.cos(one[:, 2]), np.sin(one[:, 2])
    x, y = (other - one)[:, 0], (other - one)[:, 1]
    second = np.zeros((len(one), 3, 3))
    second[:, 0, 0], second[:, 0, 1] = cos, sin
    second[:, 1, 0], second[:, 1, 1] = -sin, cos
    second[:, 2, 2] = 1.0
    first = -second.copy()
    first[:, 0, 2] = -sin * x + cos * y
    first[:, 1, 2] = -cos * x - sin * y
    return first, second


def _diagonal(values: FloatArray) -> Any:
    from scipy.sparse import diags

    return diags(values)
