"""Area of an obstacle that no sensor shows and that the base ran into."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

UNSEEN_SIZE_M = 0.45  # assumed size of what was run into: only one point of its outline is known
FRONT_ANGLE_DEG = 75.0  # to both sides of the motion, in which a disc that is stopped touches
GUARDED_ANGLE_DEG = 45.0  # likewise, in which a base keeps off on its way back: it may have slid
SPACING_M = 0.05  # between points


def bump_fronts(bumps: FloatArray, radius: float, half_angle_deg: float = GUARDED_ANGLE_DEG) -> FloatArray:
    """Return points on the outline of a base that may have touched an obstacle when the base was stopped.

    These are the points in the direction of the motion, within a sector.

    Args:
        bumps: (n, 3) x, y on the map in [m], and direction of the motion on the map in [rad].
        radius: radius of the base's footprint, in [m].
        half_angle_deg: half the angle of the sector about the direction of the motion, in [deg].

    Returns:
        (m, 2) on the map, in [m].
    """
    return _sectors(bumps, np.array([radius]), half_angle_deg)


def leading_points(outlines: Sequence[FloatArray], forwards: bool) -> FloatArray:
    """Return the points in the front half of each body, as seen in the direction in which the base drives.

    Args:
        outlines: (k, 2) points of each body in the base frame, in [m].
        forwards: True if the base drives forwards, False if backwards.

    Returns:
        (m, 2) points of all bodies in the base frame, in [m], rounded to half of `SPACING_M`.
    """
    ahead = 1.0 if forwards else -1.0
    halves = [outline[ahead * (outline[:, 0] - outline[:, 0].mean()) >= 0.0] for outline in outlines]
    points = np.vstack([np.empty((0, 2)), *halves])
    return np.asarray(np.unique(np.round(points / (0.5 * SPACING_M)), axis=0) * (0.5 * SPACING_M))


def bump_areas(bumps: FloatArray, radius: float) -> FloatArray:
    """Return points that fill the area of a possible obstacle where a base was stopped.

    The obstacle touches the front half of the footprint somewhere and may reach `UNSEEN_SIZE_M` beyond it;
    the footprint itself is free.

    Args:
        bumps: (n, 3) x, y on the map in [m], and direction of the motion on the map in [rad].
        radius: radius of the base's footprint, in [m]; 0 if a point of the arm touched.

    Returns:
        (m, 2) on the map, in [m].
    """
    depths = np.arange(0.0, UNSEEN_SIZE_M + 1e-9, SPACING_M)
    return _sectors(bumps, radius + depths, FRONT_ANGLE_DEG)


def _sectors(bumps: FloatArray, radii: FloatArray, half_angle_deg: float) -> FloatArray:
    bumps = np.asarray(bumps, dtype=np.float64).reshape(-1, 3)
    if len(bumps) == 0:
        return np.empty((0, 2))
    count = 2 * math.ceil(math.radians(half_angle_deg) * float(radii.max()) / SPACING_M) + 1
    angles = bumps[:, 2, None] + np.radians(np.linspace(-half_angle_deg, half_angle_deg, count))
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)  # (n, a, 2)
    points = bumps[:, None, None, :2] + radii[None, :, None, None] * rays[:, None]
    return np.asarray(points.reshape(-1, 2))
