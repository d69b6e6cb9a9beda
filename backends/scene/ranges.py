"""What a perfect range sensor reads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotics.geometry.pose2 import Pose2

from .solids import FloorPlan


def cast_rays(
    plan: FloorPlan, sensor: Pose2, angles: NDArray[np.float64], time: float, reach: float
) -> NDArray[np.float64]:
    """Range (n,) in [m] of each beam to the first outline of the plan; infinity beyond `reach` [m].

    `sensor` is world_T_sensor, `angles` (n,) in [rad] in its frame, `time` in [s] decides which surprises
    are there. The slab method of Kay and Kajiya, "Ray tracing complex scenes" (1986), all beams against
    all outlines at once. An outline that the sensor stands in is not seen.
    """
    if not plan.names:
        return np.full(len(angles), np.inf)
    here = plan.local(sensor.x, sensor.y)
    near = np.hypot(*np.maximum(np.abs(here) - plan.half, 0.0).T) < reach
    near &= plan.there(time)
    here, half, cos, sin = here[near], plan.half[near], plan.cos[near, None], plan.sin[near, None]
    x, y = np.cos(angles + sensor.theta), np.sin(angles + sensor.theta)
    enter, leave = _slab(here[:, :1], half[:, :1], cos * x + sin * y)
    enter_y, leave_y = _slab(here[:, 1:], half[:, 1:], cos * y - sin * x)
    np.maximum(enter, enter_y, out=enter)
    np.minimum(leave, leave_y, out=leave)
    enter[(enter > leave) | (enter <= 0.0)] = np.inf
    ranges: NDArray[np.float64] = enter.min(axis=0, initial=np.inf)
    ranges[ranges > reach] = np.inf
    return ranges


def _slab(
    here: NDArray[np.float64], half: NDArray[np.float64], direction: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where the beams (k, n) enter and leave the strips between -half and half (k, 1)."""
    slope = 1.0 / np.where(np.abs(direction) < 1e-12, 1e-12, direction)
    middle, width = -here * slope, half * np.abs(slope)
    return middle - width, middle + width
