"""Tree of frames, by the messages of `tf` and `tf_static`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from handcart.robotics.geometry.transform import Transform, difference, inverse

from .alternation import Alternation, AlternationWatch

MAX_DEPTH = 100
SAME_POSE_M, SAME_POSE_RAD = 1e-3, 1e-3
"""Difference of two poses of a static frame up to which they are the same."""
MAX_ALTERNATION_M, MAX_ALTERNATION_RAD = 0.01, math.radians(1.0)
"""Deviation of a pose from the poses before and after it up to which one node may have sent all of them."""
UPRIGHT_T_FLIPPED = np.diag([1.0, -1.0, -1.0, 1.0])
"""Pose (4, 4) of the frame of a sensor mounted upside down, in its upright frame; half a turn about x."""


class FrameTree:
    """Tree of coordinate frames from `tf` messages, with the last pose of each frame in its parent frame.

    Frames with two parents, static frames with two poses, and frames whose poses alternate as those of two
    nodes do, are noted: which pose counts is left to chance.
    """

    def __init__(self) -> None:
        """Begin without frames."""
        self._parents: dict[str, tuple[str, Transform]] = {}
        self._conflicts: dict[str, str] = {}
        self._alternations: dict[tuple[str, str], AlternationWatch] = {}

    def take(self, message: Any) -> None:
        """Store the poses of a `tf2_msgs/TFMessage` of `tf`; poses that are not finite are ignored."""
        self._take(message, is_static=False)

    def take_static(self, message: Any) -> None:
        """Store the poses of a `tf2_msgs/TFMessage` of `tf_static`, which later ones must not change."""
        self._take(message, is_static=True)

    def _take(self, message: Any, is_static: bool) -> None:
        for transform in message.transforms:
            pose = pose_of_transform(transform.transform)
            if pose is None:
                continue
            child, parent = plain(transform.child_frame_id), plain(transform.header.frame_id)
            before = self._parents.get(child)
            words = "" if before is None else _conflict(before, (parent, pose), is_static)
            if not is_static and (found := self._note(child, parent, transform.header.stamp, pose)):
                words = words or _alternation_words(parent, found)
            if words:
                self._conflicts.setdefault(child, f"the frame {child!r} has {words}")
            self._parents[child] = parent, pose

    def _note(self, child: str, parent: str, stamp: Any, pose: Transform) -> Alternation | None:
        """Note a moving frame's pose parent_T_child (4, 4); return by how much its poses alternate."""
        limits = (*[MAX_ALTERNATION_M] * 3, *[MAX_ALTERNATION_RAD] * 9)
        watch = self._alternations.setdefault((child, parent), AlternationWatch(limits))
        values = [*pose[:3, 3].tolist(), *pose[:3, :3].ravel().tolist()]
        return watch.note(stamp.sec + stamp.nanosec / 1e9, values)

    def conflicts(self, frame: str) -> list[str]:
        """Return a text for each contradiction of messages about a frame or the frames above it."""
        frame, found = plain(frame), []
        for _ in range(MAX_DEPTH):
            if frame in self._conflicts:
                found.append(self._conflicts[frame])
            if frame not in self._parents:
                break
            frame, _ = self._parents[frame]
        return found

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


def _conflict(before: tuple[str, Transform], after: tuple[str, Transform], is_static: bool) -> str:
    """Return how two messages about one frame contradict each other, as text; "" if they agree.

    Args:
        before: parent and parent_T_frame (4, 4) of the earlier message.
        after: those of the later one.
        is_static: True if the frame may not move in its parent.
    """
    if before[0] != after[0]:
        return f"two parents, {before[0]!r} and {after[0]!r}"
    off, angle = difference(before[1], after[1])
    if not is_static or (off <= SAME_POSE_M and angle <= SAME_POSE_RAD):
        return ""
    degrees = math.degrees(angle)
    return f"two static poses in {after[0]!r}, {off:.3f} m and {degrees:.1f} deg apart"


def _alternation_words(parent: str, found: Alternation) -> str:
    size = f"{found.size:.3f} m" if found.number < 3 else f"{math.degrees(found.size):.1f} deg"
    return f"poses in {parent!r} that go to and fro by {size}"


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


def lidar_pose(base_T_lidar: Transform, is_upside_down: bool) -> Transform:
    """Return base_T_frame (4, 4) of the frame in which a lidar's driver has to publish its scans.

    Args:
        base_T_lidar: (4, 4) pose of the lidar's frame by the robot's file, upright or not.
        is_upside_down: True if the robot's file says that the lidar is mounted upside down.
    """
    return base_T_lidar @ UPRIGHT_T_FLIPPED if (base_T_lidar[2, 2] < 0.0) != is_upside_down else base_T_lidar


def plain(frame: str) -> str:
    """Return a frame's name without a leading slash, which was usual in ROS 1."""
    return frame.lstrip("/")
