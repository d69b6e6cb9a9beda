"""Poses in space as (4, 4) arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

Transform = Annotated[FloatArray, (4, 4)]


def transform(xyz: Sequence[float] = (0.0, 0.0, 0.0), rpy: Sequence[float] = (0.0, 0.0, 0.0)) -> Transform:
    """Return a pose from a position in [m] and roll, pitch, yaw about fixed axes in [rad] (URDF's order)."""
    # Written out: SciPy's Rotation takes twenty times as long for a single one.
    (sr, sp, sy), (cr, cp, cy) = (tuple(map(f, rpy)) for f in (math.sin, math.cos))
    x, y, z = xyz
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, x],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, y],
            [-sp, cp * sr, cp * cr, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def rotations(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> FloatArray:
    """Return the rotations world_R_base (n, 3, 3) of roll, pitch and yaw, (n,) each in [rad].

    Each is Rz(yaw) Ry(pitch) Rx(roll).
    """
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def inverse(a_T_b: Transform) -> Transform:
    """Return b_T_a (4, 4), the inverse of a_T_b (4, 4)."""
    result, turn = np.zeros((4, 4)), a_T_b[:3, :3].T
    result[:3, :3], result[:3, 3], result[3, 3] = turn, -turn @ a_T_b[:3, 3], 1.0
    return result


def apply(a_T_b: Transform, points: FloatArray) -> FloatArray:
    """Return points (n, 3) of frame b in frame a, in [m].

    Args:
        a_T_b: (4, 4) pose of b in a.
        points: (n, 3) in b, in [m].
    """
    moved: FloatArray = points @ a_T_b[:3, :3].T + a_T_b[:3, 3]
    return moved


def raised(a_T_b: Transform, by: float) -> Transform:
    """Return a pose moved along z of its reference frame.

    Args:
        a_T_b: (4, 4) the pose.
        by: the distance, in [m]; negative for down.
    """
    result = a_T_b.copy()
    result[2, 3] += by
    return result


def distance(a_T_b: Transform, a_T_c: Transform) -> float:
    """Return the distance between the origins of b and c, in [m]."""
    return float(np.linalg.norm(a_T_b[:3, 3] - a_T_c[:3, 3]))


def difference(a_T_b: Transform, a_T_c: Transform) -> tuple[float, float]:
    """Return the distance between b and c in [m], and the angle of the turn between them in [rad]."""
    # Late: whatever reads a robot's file imports this module, and few ask for an angle.
    from scipy.spatial.transform import Rotation

    turn = a_T_b[:3, :3].T @ a_T_c[:3, :3]
    return distance(a_T_b, a_T_c), float(Rotation.from_matrix(turn).magnitude())
