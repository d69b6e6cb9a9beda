"""Tilt of a base on its suspension when the arm reaches out."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from handcart.robotics.geometry.transform import Transform, transform


@lru_cache(maxsize=16)
def leaning(lean: tuple[float, float], pivot: float) -> Transform:
    """Return upright_T_leaning (4, 4), the read-only pose of a tilted base in the upright base's frame.

    Args:
        lean: roll and pitch, in [rad].
        pivot: height of the point about which the base tilts, in [m].
    """
    up, down = transform((0.0, 0.0, pivot)), transform((0.0, 0.0, -pivot))
    pose = np.asarray(up @ transform(rpy=(lean[0], lean[1], 0.0)) @ down)
    pose.flags.writeable = False
    return pose


def lean_of(reach: tuple[float, float], mrad_per_m: float) -> tuple[float, float]:
    """Return roll and pitch of the base in [rad]; the side that the hand is on sinks.

    The tilt is proportional to the hand's distance: the centre of gravity moves with the arm and the springs
    are linear (paper of Hatano et al. 2000, section 4).

    Args:
        reach: x and y of the hand in the base frame, in [m].
        mrad_per_m: tilt for each metre of the hand's distance, in [mrad/m].
    """
    rate = mrad_per_m / 1e3
    return -rate * reach[1], rate * reach[0]
