"""A depth camera, by two topics of `sensor_msgs/Image`: depth and colour."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.depth_camera import DepthCamera, DepthImage
from handcart.backends.live.sensor_errors import StaleSensor
from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.topic_sensor import TopicSensor
from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, SingleArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

DEPTH_TYPES = {"16UC1": ("u2", 1e-3), "mono16": ("u2", 1e-3), "32FC1": ("f4", 1.0)}
"""Encodings of depth: NumPy's type of a pixel, and the length of a step in [m]."""
TO_COLOUR = {
    "rgb8": (3, None),
    "bgr8": (3, cv2.COLOR_BGR2RGB),
    "8UC3": (3, cv2.COLOR_BGR2RGB),
    "rgba8": (4, cv2.COLOR_RGBA2RGB),
    "bgra8": (4, cv2.COLOR_BGRA2RGB),
    "mono8": (1, cv2.COLOR_GRAY2RGB),
}
"""Encodings of colour: channels, and OpenCV's conversion to RGB."""
KEPT_PICTURES = 5
PAIR_S = 0.1
"""Largest difference of the stamps of depth and colour of one picture, in [s]."""


class PictureTopic(TopicSensor):
    """ROS topic with pictures of a known size; the last five messages are stored without converting them."""

    KIND = "sensor_msgs/Image"

    def fit(self, width: int, height: int, channels: dict[str, int]) -> None:
        """Set the size and encodings of the expected pictures, before the first message.

        Args:
            width: width in [px].
            height: height in [px].
            channels: number of bytes of a pixel, by accepted encoding.
        """
        self._size, self._channels = (width, height), channels
        self.kept: deque[Any] = deque(maxlen=KEPT_PICTURES)

    @override
    def _wrong(self, message: Any) -> str:
        if message.encoding not in self._channels:
            return f"its encoding is {message.encoding!r}; allowed: {', '.join(self._channels)}"
        if (message.width, message.height) != self._size:
            received, wanted = f"{message.width} x {message.height}", f"{self._size[0]} x {self._size[1]}"
            return f"its pictures have {received} pixels; the robot's file says {wanted}"
        needed = self._channels[message.encoding] * message.width
        if message.step < needed or len(message.data) < message.step * message.height:
            return f"it has {len(message.data)} bytes; needed: {needed * message.height}"
        return ""

    @override
    def _read(self, messages: list[Any]) -> None:
        self.kept.extend(messages)

    @override
    def _note_clock_step(self, step_s: float) -> None:
        super()._note_clock_step(step_s)
        for message in self.kept:  # the next picture of the other topic has a stamp of the new time
            set_stamp(message.header, stamp_of(message) + step_s)

    @override
    def forget(self) -> None:
        super().forget()
        self.kept.clear()


class RosDepthCamera(DepthCamera):
    """Depth camera that pairs each depth picture with the colour picture and the measured joints nearest in
    time.
    """

    def __init__(
        self,
        spec: DepthCameraSpec,
        depth: PictureTopic,
        colour: PictureTopic,
        pose: Callable[[float], Transform],
        begun: float,
    ) -> None:
        """Take over both topics.

        Args:
            spec: the camera's section of the robot's file.
            depth: topic of the camera's depth.
            colour: topic of the camera's colours, registered to the depth.
            pose: returns base_T_camera (4, 4) of the optical frame (z forward, x right, y down) at a stamp in
                [s].
            begun: stamp in [s] from which the time of a picture counts.
        """
        self._spec, self._depth, self._colour, self._pose, self._begun = spec, depth, colour, pose, begun
        depth.fit(spec.width_px, spec.height_px, {"16UC1": 2, "mono16": 2, "32FC1": 4})
        colours = {name: channels for name, (channels, _) in TO_COLOUR.items()}
        colour.fit(spec.width_px, spec.height_px, colours)
        self._last: tuple[Any, DepthImage] | None = None

    @property
    @override
    def model(self) -> CameraModel:
        return self._spec.model

    @override
    def image(self) -> DepthImage:
        """Return the last depth picture with the colour picture nearest in time.

        Raises:
            StaleSensor: one of the two pictures is too old, or their times differ by more than 0.1 s.
        """
        self._depth.check_fresh()
        self._colour.check_fresh()
        message = self._depth.kept[-1]
        if self._last is None or self._last[0] is not message:
            self._last = message, self._taken(message)
        return self._last[1]

    def _taken(self, message: Any) -> DepthImage:
        stamp = stamp_of(message)
        colour = min(self._colour.kept, key=lambda item: abs(stamp_of(item) - stamp))
        off = abs(stamp_of(colour) - stamp)
        if off > PAIR_S:
            words = f"its nearest depth is {off:.2g} s away; allowed: {PAIR_S:g} s"
            raise StaleSensor(self._colour.name, self._colour.age, PAIR_S, words)
        depth = depth_of(message, self._spec.range_min_m, self._spec.reach_m)
        image = DepthImage(colour_of(colour), depth, self._pose(stamp), stamp - self._begun)
        for part in (image.colour, image.depth, image.base_T_camera):
            part.flags.writeable = False
        return image


def depth_of(message: Any, nearest: float, farthest: float) -> SingleArray:
    """Return the depth (height, width) of a message, in [m] along the optical axis; NaN without a reading.

    Args:
        message: `sensor_msgs/Image` with an encoding of `DEPTH_TYPES`.
        nearest: smallest valid depth, in [m].
        farthest: largest valid depth, in [m].
    """
    kind, unit = DEPTH_TYPES[message.encoding]
    order = ">" if message.is_bigendian else "<"
    size = np.dtype(kind).itemsize
    rows = np.frombuffer(bytes(message.data), np.uint8)[: message.step * message.height]
    pixels = rows.reshape(message.height, message.step)[:, : size * message.width]
    depth = np.ascontiguousarray(pixels).view(order + kind).astype(np.float32) * np.float32(unit)
    depth[~((depth > 0.0) & (depth >= nearest) & (depth <= farthest))] = np.nan
    return depth


def colour_of(message: Any) -> ByteArray:
    """Return the picture (height, width, 3) of a message in RGB, 0 to 255.

    Args:
        message: `sensor_msgs/Image` with an encoding of `TO_COLOUR` and complete data.
    """
    channels, conversion = TO_COLOUR[message.encoding]
    rows = np.frombuffer(bytes(message.data), np.uint8)[: message.step * message.height]
    pixels = rows.reshape(message.height, message.step)[:, : channels * message.width]
    picture = pixels.reshape(message.height, message.width, channels).copy()
    if conversion is None:
        return picture
    return np.ascontiguousarray(cv2.cvtColor(picture, conversion), np.uint8)


def stamp_of(message: Any) -> float:
    """Return the time stamp in the header of a ROS message, in [s]."""
    return float(message.header.stamp.sec) + float(message.header.stamp.nanosec) / 1e9
