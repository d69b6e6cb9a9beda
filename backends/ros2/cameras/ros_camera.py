"""A camera, by `sensor_msgs/Image`."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from typing_extensions import override

from handcart.backends.robot.mounted_camera import MountedCamera
from handcart.backends.robot.placed_camera import PlacedCamera
from handcart.backends.ros2.wire.topic_sensor import TopicSensor
from handcart.robotics.numerics.arrays import ByteArray

TO_GREY = {
    "mono8": (1, None),
    "8UC1": (1, None),
    "rgb8": (3, cv2.COLOR_RGB2GRAY),
    "bgr8": (3, cv2.COLOR_BGR2GRAY),
    "8UC3": (3, cv2.COLOR_BGR2GRAY),
    "rgba8": (4, cv2.COLOR_RGBA2GRAY),
    "bgra8": (4, cv2.COLOR_BGRA2GRAY),
}
"""Encodings of pictures that are read, each with its number of channels, and OpenCV's conversion to grey."""


class RosCamera(TopicSensor, PlacedCamera):
    """Camera whose pictures are received from a ROS topic and converted to grey."""

    KIND = "sensor_msgs/Image"
    _message: Any = None
    _image: ByteArray | None = None
    """Picture (height, width), grey, of the last message, decoded once it is requested; None: not yet."""

    def fit(self, mounted: MountedCamera) -> None:
        """Set the camera's intrinsics and mounting pose, before the first picture."""
        self._known = mounted

    @override
    def image(self) -> ByteArray:
        """Return the last picture (height, width), grey, 0 to 255; raise `StaleSensor` if it is too old."""
        self.check_fresh()
        if self._image is None:
            self._image = grey_picture(self._message)
        return self._image

    @override
    def _wrong(self, message: Any) -> str:
        model = self._known.model
        if message.encoding not in TO_GREY:
            return f"its encoding is {message.encoding!r}; allowed: {', '.join(TO_GREY)}"
        if (message.width, message.height) != (model.width, model.height):
            size = f"{message.width} x {message.height}"
            return f"its pictures have {size} pixels; the robot's file says {model.width} x {model.height}"
        channels = TO_GREY[message.encoding][0]
        if message.step < channels * message.width or len(message.data) < message.step * message.height:
            return f"it has {len(message.data)} bytes; needed: {channels * message.width * message.height}"
        return ""

    @override
    def _read(self, messages: list[Any]) -> None:
        self._message, self._image = messages[-1], None


def grey_picture(message: Any) -> ByteArray:
    """Return the picture (height, width) of a message as a read-only copy, grey from 0 to 255.

    Args:
        message: `sensor_msgs/Image` with complete data, whose encoding is a key of `TO_GREY`.
    """
    channels, conversion = TO_GREY[message.encoding]
    rows = np.frombuffer(bytes(message.data), np.uint8)[: message.step * message.height]
    pixels = rows.reshape(message.height, message.step)[:, : channels * message.width]
    if conversion is None:
        picture: ByteArray = pixels.copy()
    else:
        colours = pixels.reshape(message.height, message.width, channels).copy()
        picture = np.ascontiguousarray(cv2.cvtColor(colours, conversion), np.uint8)
    picture.flags.writeable = False
    return picture
