"""Orientations whose x axis points along a given direction."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.transform import Transform, transform

VERTICAL_COSINE = 0.99  # cosine to the vertical beyond which no axis can be upright


def pointing(direction: tuple[float, float, float], roll: float = 0.0) -> Transform:
    """Return a rotation (4, 4) whose x axis points along a direction.

    Without roll the z axis is as upright as possible. For a vertical direction, the y axis is that of the
    base frame.

    Args:
        direction: vector of any length above 0, in the base frame.
        roll: additional turn about the direction, in [rad].

    Raises:
        ValueError: the direction has no length, or isn't finite.
    """
    x = np.array(direction, dtype=np.float64)
    length = float(np.linalg.norm(x))
    if not math.isfinite(length) or length == 0.0:
        raise ValueError(f"the direction {direction} has no length; allowed: three finite numbers, not all 0")
    x /= length
    is_vertical = abs(x[2]) > VERTICAL_COSINE
    y = np.array([0.0, 1.0, 0.0]) - x[1] * x if is_vertical else np.cross((0.0, 0.0, 1.0), x)
    y /= np.linalg.norm(y)
    result = np.eye(4)
    result[:3, :3] = np.column_stack((x, y, np.cross(x, y)))
    return np.asarray(result @ transform(rpy=(roll, 0.0, 0.0)))
