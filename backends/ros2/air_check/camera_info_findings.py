"""Comparison of a camera's `camera_info` on the air with the robot's file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import ValidationError

from handcart.backends.description.camera_info import CameraInfo
from handcart.backends.description.ros_spec import RosCameraSpec, RosDepthSpec
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .air_finding import AirFinding

MAX_RAY_ERROR_PX = 5.0
"""Largest distance between the pixels at which two models see the same ray."""
RECTIFIED_TOPIC_PART = "rect"


def camera_info_findings(
    place: tuple[str, ...], topics: RosCameraSpec | RosDepthSpec, ours: CameraModel, message: Any
) -> Iterator[AirFinding]:
    """Yield the differences between a published camera calibration and the calibration in the robot's file.

    Args:
        place: key path of the camera in the robot's file.
        topics: the camera's topics.
        ours: camera model by the robot's file.
        message: the last published `CameraInfo`; None if none has arrived.
    """
    topic = topics.info_topic
    if message is None:
        yield AirFinding(("ros2", "camera"), f"{topic}: no camera_info arrives", is_fault=False)
    elif not any(message.k):
        yield AirFinding(place, f"{topic}: the driver has no calibration (K is zero)", is_fault=False)
    elif (message.width, message.height) != (ours.width, ours.height):
        sizes = (
            f"{message.width} x {message.height} pixels; the robot's file says {ours.width} x {ours.height}"
        )
        yield AirFinding(place, f"{topic}: calibrated for {sizes}")
    else:
        yield from _lens_findings(place, topic, ours, message, RECTIFIED_TOPIC_PART in topics.topic)


def _lens_findings(
    place: tuple[str, ...], topic: str, ours: CameraModel, message: Any, rectified: bool
) -> Iterator[AirFinding]:
    try:
        theirs = _model_of(message, rectified)
    except ValidationError as wrong:
        yield AirFinding(place, f"{topic}: {wrong.errors()[0]['msg']}", is_fault=False)
        return
    off = ray_error(ours, theirs)
    if off > MAX_RAY_ERROR_PX:
        yield AirFinding(
            place,
            f"{topic}: its lens ({_lens(theirs)}) sees a ray up to {off:.0f} px from where that of the robot"
            f" ({_lens(ours)}) does; allowed: {MAX_RAY_ERROR_PX:g} px",
        )


def ray_error(ours: CameraModel, theirs: CameraModel) -> float:
    """Return the largest distance, in [px], between the two pixels that two camera models assign to the same
    ray.
    """
    last = np.array([ours.width - 1.0, ours.height - 1.0])
    pixels = np.array([[x, y] for x in np.linspace(0.0, 1.0, 9) for y in np.linspace(0.0, 1.0, 9)]) * last
    rays = ours.undistort(pixels)
    seen = theirs.project(np.column_stack([rays, np.ones(len(rays))]))
    return float(np.nan_to_num(np.hypot(*(seen - pixels).T), nan=np.inf).max())


def _model_of(message: Any, rectified: bool) -> CameraModel:
    """Return the camera model of a `CameraInfo` message: by K and D, or by P for rectified pictures."""
    K = np.asarray(message.p, np.float64).reshape(3, 4)[:, :3] if rectified else np.asarray(message.k)
    info = CameraInfo.model_validate(
        {
            "image_width": int(message.width),
            "image_height": int(message.height),
            "camera_matrix": {"data": K.ravel().tolist()},
            "distortion_model": "plumb_bob" if rectified else message.distortion_model or "plumb_bob",
            "distortion_coefficients": {"data": [] if rectified else list(message.d)},
        }
    )
    return info.model


def _lens(camera: CameraModel) -> str:
    K = camera.K
    return f"focal {K[0, 0]:.1f} {K[1, 1]:.1f}, centre {K[0, 2]:.1f} {K[1, 2]:.1f}"
