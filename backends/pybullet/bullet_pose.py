"""Poses as Bullet has them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray


def placed(pose: Transform) -> tuple[list[float], list[float]]:
    """Return a pose (4, 4) in any frame as Bullet's position x, y, z in [m], unit quaternion x, y, z, w."""
    return pose[:3, 3].tolist(), Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()


def matrix(position: Sequence[float], quaternion: Sequence[float]) -> Transform:
    """Return the pose (4, 4) of a position x, y, z in [m] and a unit quaternion x, y, z, w, both in one
    frame.
    """
    x, y, z, w = quaternion
    result: FloatArray = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), position[0]],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), position[1]],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), position[2]],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    return result
