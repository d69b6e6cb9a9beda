"""Poses as seven numbers: x, y, z in [m], then a unit quaternion with its real part first."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

Seven = tuple[float, float, float, float, float, float, float]


def sevens(poses: FloatArray) -> FloatArray:
    """Convert poses from homogeneous transforms to rows (n, 7) of position and unit quaternion.

    A row is x, y, z in [m] and w, x, y, z of the quaternion, in the frame of the transforms.

    Args:
        poses: (n, 4, 4) homogeneous transforms, in any frame.
    """
    if len(poses) == 0:
        return np.empty((0, 7))
    turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat(canonical=True, scalar_first=True)
    return np.column_stack((poses[:, :3, 3], turns))


def seven(pose: Transform) -> Seven:
    """Convert a pose (4, 4) in any frame to x, y, z in [m] and a unit quaternion w, x, y, z."""
    x, y, z, qw, qx, qy, qz = sevens(pose[None])[0].tolist()
    return x, y, z, qw, qx, qy, qz


def transforms(rows: FloatArray) -> FloatArray:
    """Return poses as homogeneous transforms (n, 4, 4), in the same frame.

    Args:
        rows: (n, 7) in any frame, x, y, z in [m], and a unit quaternion w, x, y, z.
    """
    found = np.tile(np.eye(4), (len(rows), 1, 1))
    if len(rows):
        found[:, :3, :3] = Rotation.from_quat(rows[:, 3:], scalar_first=True).as_matrix()
        found[:, :3, 3] = rows[:, :3]
    return found


def on_floor(poses: FloatArray) -> FloatArray:
    """Return planar poses as rows (n, 7) with z = 0: x, y, z in [m], and a unit quaternion w, x, y, z.

    Args:
        poses: (n, 3) x, y in [m], heading in [rad], in any frame with z up; the rows are in that frame.
    """
    found = np.zeros((len(poses), 7))
    found[:, :2] = poses[:, :2]
    found[:, 3], found[:, 6] = np.cos(poses[:, 2] / 2), np.sin(poses[:, 2] / 2)
    return found


def between(a: FloatArray, b: FloatArray, share: float) -> FloatArray:
    """Interpolate two poses: linearly in position, by slerp in orientation.

    Args:
        a: (7,) pose at share 0: x, y, z in [m], and a unit quaternion w, x, y, z.
        b: (7,) pose at share 1, in the same frame.
        share: 0 to 1.

    Returns:
        The interpolated pose (7,), in the same form and frame.
    """
    other = b[3:] if float(a[3:] @ b[3:]) >= 0.0 else -b[3:]
    cosine = min(1.0, float(a[3:] @ other))
    angle = math.acos(cosine)
    if angle < 1e-3:
        turn = (1.0 - share) * a[3:] + share * other
    else:
        turn = (math.sin((1.0 - share) * angle) * a[3:] + math.sin(share * angle) * other) / math.sin(angle)
    return np.concatenate(((1.0 - share) * a[:3] + share * b[:3], turn / np.linalg.norm(turn)))
