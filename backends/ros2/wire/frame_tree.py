"""Tree of frames, by the messages of `tf` and `tf_static`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse

MAX_DEPTH = 100
UPRIGHT_T_FLIPPED = np.diag([1.0, -1.0, -1.0, 1.0])
"""Pose (4, 4) of the frame of a sensor mounted upside down, in its upright frame; half a turn about x."""


class FrameTree:
    """Tree of coordinate frames from `tf` messages, with the last pose of each frame in its parent frame."""

    def __init__(self) -> None:
        """Begin without frames."""
        self._parents: dict[str, tuple[str, Transform]] = {}

    def take(self, message: Any) -> None:
        """Store the poses of a `tf2_msgs/TFMessage`; poses that are not finite are ignored."""
        for transform in message.transforms:
            pose = pose_of_transform(transform.transform)
            if pose is not None:
                self._parents[plain(transform.child_frame_id)] = plain(transform.header.frame_id), pose

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of all frames that have a parent."""
        return tuple(self._parents)

    def pose(self, base: str, frame: str) -> Transform | None:
        """Return the pose base_T_frame (4, 4) of one frame in another; None if they are not connected."""
        of_base, of_frame = self._to_root(plain(base)), self._to_root(plain(frame))
        if of_base is None or of_frame is None or of_base[0] != of_frame[0]:
            return None
        return inverse(of_base[1]) @ of_frame[1]

    def _to_root(self, frame: str) -> tuple[str, Transform] | None:
        """Return the root above a frame, and root_T_frame (4, 4); None if the parents form a circle."""
        pose: Transform = np.eye(4)
        for _ in range(MAX_DEPTH):
            if frame not in self._parents:
                return frame, pose
            frame, parent_T_frame = self._parents[frame]
            pose = parent_T_frame @ pose
        return None


def pose_of_transform(message: Any) -> Transform | None:
    """Return parent_T_child (4, 4) of a `geometry_msgs/Transform`; None if it is not finite, or its
    quaternion is not of length 1.
    """
    place, turn = message.translation, message.rotation
    x, y, z, w = float(turn.x), float(turn.y), float(turn.z), float(turn.w)
    norm = math.hypot(x, y, z, w)
    numbers = (float(place.x), float(place.y), float(place.z), norm)
    if not all(map(math.isfinite, numbers)) or not 0.99 < norm < 1.01:
        return None
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), numbers[0]],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), numbers[1]],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), numbers[2]],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def plain(frame: str) -> str:
    """Return a frame's name without a leading slash, which was usual in ROS 1."""
    return frame.lstrip("/")
