"""What of a level scan may be ground that rises, and no obstacle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

RISES = 0.15  # [m/m] by which ground may rise from where the base stands


def may_be_ground(points: NDArray[np.float64], height: float, tilt: tuple[float, float]) -> NDArray[np.bool_]:
    """Whether points (n, 2) of a scan lie so low that ground may reach them.

    On a base that is tilted a beam sinks on its way, or the ground rises to it. An obstacle is higher: it is
    told from the ground once it is so near that ground isn't that steep.

    Args:
        points: in the base frame, in [m].
        height: of the sensor above the ground under the base, in [m].
        tilt: roll and pitch of the base in [rad].
    """
    roll, pitch = tilt
    ahead, left = points.T
    lies = height - math.sin(pitch) * ahead + math.cos(pitch) * math.sin(roll) * left
    return np.asarray(lies <= RISES * np.hypot(ahead, left))
