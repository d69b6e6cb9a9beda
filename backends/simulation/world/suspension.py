"""Tilt of a base on its suspension when the arm reaches out."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from handcart.robotics.geometry.transform import Transform, transform


@lru_cache(maxsize=16)
def leaning(lean: tuple[float, float], pivot: float) -> Transform:
    """Return the pose (4, 4) of a leaning base in the upright base; it is read only.

    Args:
        lean: roll and pitch, in [rad].
        pivot: height of the point that stays where it is, in [m].
    """
    up, down = transform((0.0, 0.0, pivot)), transform((0.0, 0.0, -pivot))
    pose = np.asarray(up @ transform(rpy=(lean[0], lean[1], 0.0)) @ down)
    pose.flags.writeable = False
    return pose


def lean_of(reach: tuple[float, float], mrad_per_m: float) -> tuple[float, float]:
    """Return roll and pitch in [rad] with the hand `reach` from the base's centre along x and y, in [m].

    The side that the hand is on sinks, in proportion to how far out it is: the centre of gravity moves with
    the arm and the springs are linear (paper of Hatano et al. 2000, section 4).
    """
    rate = mrad_per_m / 1e3
    return -rate * reach[1], rate * reach[0]
