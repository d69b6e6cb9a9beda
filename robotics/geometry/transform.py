"""Poses in space as (4, 4) arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Transform = NDArray[np.float64]


def transform(xyz: Sequence[float] = (0.0, 0.0, 0.0), rpy: Sequence[float] = (0.0, 0.0, 0.0)) -> Transform:
    """A pose from a position in [m] and roll, pitch, yaw about fixed axes in [rad] (URDF's order)."""
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    result[:3, 3] = xyz
    return result


def inverse(a_T_b: Transform) -> Transform:
    """b_T_a of a_T_b."""
    result = np.eye(4)
    result[:3, :3] = a_T_b[:3, :3].T
    result[:3, 3] = -a_T_b[:3, :3].T @ a_T_b[:3, 3]
    return result


def apply(a_T_b: Transform, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 3) given in b, in a."""
    moved: NDArray[np.float64] = points @ a_T_b[:3, :3].T + a_T_b[:3, 3]
    return moved


def difference(a_T_b: Transform, a_T_c: Transform) -> tuple[float, float]:
    """How far b and c are apart: distance in [m], and angle of the turn between them in [rad]."""
    distance = float(np.linalg.norm(a_T_b[:3, 3] - a_T_c[:3, 3]))
    turn = a_T_b[:3, :3].T @ a_T_c[:3, :3]
    return distance, float(Rotation.from_matrix(turn).magnitude())
