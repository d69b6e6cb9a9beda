"""Times and poses as Foxglove's schemas have them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from foxglove.messages import Pose, Quaternion, Timestamp, Vector3

MAP = "map"
"""The frame of the map, which is the simulated world's too."""
Message = tuple[float, str, Any]
"""When, in [s] of the robot's time; on which topic; and what."""


def nanoseconds(time: float) -> int:
    """Of a time in [s]."""
    return round(1e9 * time)


def stamp(time: float) -> Timestamp:
    """Of a time in [s]."""
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(nanoseconds(time), 1_000_000_000))


def pose_of(pose: NDArray[np.float64]) -> Pose:
    """Of a pose (7,), or of one in the plane (3,): x, y in [m], heading in [rad]."""
    from foxglove.messages import Pose

    return Pose(position=position_of(pose), orientation=orientation_of(pose))


def position_of(pose: NDArray[np.float64]) -> Vector3:
    """The same, of where it is."""
    from foxglove.messages import Vector3

    x, y, *rest = pose.tolist()
    return Vector3(x=x, y=y, z=rest[0] if len(pose) == 7 else 0.0)


def orientation_of(pose: NDArray[np.float64]) -> Quaternion:
    """The same, of which way it is turned."""
    from foxglove.messages import Quaternion

    if len(pose) == 7:
        _, _, _, w, x, y, z = pose.tolist()
        return Quaternion(x=x, y=y, z=z, w=w)
    half = 0.5 * float(pose[2])
    return Quaternion(x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))
