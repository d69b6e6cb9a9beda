"""Times and poses in Foxglove's schemas."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from handcart.robotics.numerics.arrays import FloatArray

if TYPE_CHECKING:
    from foxglove.messages import Pose, Quaternion, Timestamp, Vector3

MAP_FRAME = "map"
"""Name of the map's frame, in which all poses are exported, those of the simulated world, too."""
Message = tuple[float, str, Any]
"""A message to export, as time in [s] of the robot's clock, topic, and content."""


def nanoseconds(time: float) -> int:
    """Convert a time in [s] to [ns]."""
    return round(1e9 * time)


def stamp(time: float) -> Timestamp:
    """Convert a time in [s] to a Foxglove timestamp."""
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(nanoseconds(time), 1_000_000_000))


def pose_of(pose: FloatArray) -> Pose:
    """Convert a pose to a Foxglove Pose in the same frame.

    Args:
        pose: (7,) x, y, z in [m], and a unit quaternion w, x, y, z; or (3,) x, y in [m], heading in [rad].
    """
    from foxglove.messages import Pose

    return Pose(position=position_of(pose), orientation=orientation_of(pose))


def position_of(pose: FloatArray) -> Vector3:
    """Return the position of a pose as a Foxglove Vector3 in the same frame, in [m].

    Args:
        pose: (7,) x, y, z in [m], and a unit quaternion w, x, y, z; or (3,) x, y in [m], heading in [rad].
    """
    from foxglove.messages import Vector3

    x, y, *rest = pose.tolist()
    return Vector3(x=x, y=y, z=rest[0] if len(pose) == 7 else 0.0)


def orientation_of(pose: FloatArray) -> Quaternion:
    """Return the orientation of a pose as a Foxglove Quaternion in the same frame.

    Args:
        pose: (7,) x, y, z in [m], and a unit quaternion w, x, y, z; or (3,) x, y in [m], heading in [rad].
    """
    from foxglove.messages import Quaternion

    if len(pose) == 7:
        _, _, _, w, x, y, z = pose.tolist()
        return Quaternion(x=x, y=y, z=z, w=w)
    half = 0.5 * float(pose[2])
    return Quaternion(x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))
