"""Odometry by `tf`, where no topic has it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from typing_extensions import override

from .ros_base import OdometryTopic
from .wire.frame_tree import plain


class FrameOdometry(OdometryTopic):
    """Wheel odometry computed from the base's poses in the odometry frame, which are published on `tf`."""

    KIND = "tf2_msgs/TFMessage"
    HAS_ONE_NODE = False

    @override
    def heard(self, message: Any) -> None:
        child, frame = plain(self._limits.child_frame), self.source.frame
        for transform in message.transforms:
            is_wanted = plain(transform.child_frame_id) == child
            if is_wanted and (frame is None or plain(transform.header.frame_id) == plain(frame)):
                place, turn = transform.transform.translation, transform.transform.rotation
                pose = SimpleNamespace(pose=SimpleNamespace(position=place, orientation=turn))
                self._arrived.append(SimpleNamespace(header=transform.header, pose=pose))
