"""The bright face nearest to where a block was expected, to explain why no block was found there."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, SingleArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

HALF_VIEW_M = 0.08  # from the expected place to the edges of the searched square
M_PER_PX = 0.001
MIN_CONTRAST_GREY = 10.0  # between the face and its surroundings
MIN_FACE_AREA_M2 = 1e-4


class Face(NamedTuple):
    """Bright rectangle that was found in a plane, with its size and its difference from the expected pose."""

    long_side: float
    """Length of the long side, in [m]."""
    short_side: float
    """Length of the short side, in [m]."""
    distance: float
    """Distance of its centre from the expected one, in [m]."""
    direction: float
    """Direction of its long side from the expected pose's x axis, in [rad], from -pi / 2 to pi / 2."""


def nearest_face(
    image: ByteArray, camera: CameraModel, camera_T_plane: Transform, expected: Pose2
) -> Face | None:
    """Return the bright face nearest to an expected pose in the plane z = 0 of a frame.

    None if no bright face is completely within `HALF_VIEW_M` along both axes. The result is less accurate
    than that of `find_block`, about 2 mm, but needs no expected size.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        camera_T_plane: (4, 4) pose of the frame.
        expected: expected plane_T_face, in [m] and [rad].
    """
    side = 2 * round(HALF_VIEW_M / M_PER_PX) + 1
    to_plane = np.array([[M_PER_PX, 0.0, -HALF_VIEW_M], [0.0, M_PER_PX, -HALF_VIEW_M], [0.0, 0.0, 1.0]])
    camera_T_expected = camera_T_plane @ expected.lift()
    flat = camera.rectify(image, camera_T_expected[:, (0, 1, 3)][:3] @ to_plane, (side, side))
    smooth = np.asarray(cv2.GaussianBlur(flat, (5, 5), 0.0), dtype=np.uint8)
    _, otsu = cv2.threshold(smooth, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    bright = np.asarray(otsu, dtype=np.uint8)
    if _contrast(smooth, bright) < MIN_CONTRAST_GREY:
        return None
    outlines, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    faces = [
        _face(np.asarray(outline, np.float32), side)
        for outline in outlines
        if 0 < outline.min() <= outline.max() < side - 1
    ]
    large = [face for face in faces if face.long_side * face.short_side >= MIN_FACE_AREA_M2]
    return min(large, key=lambda face: face.distance, default=None)


def _contrast(flat: ByteArray, bright: ByteArray) -> float:
    """Return the difference of the mean grey levels of bright and dark pixels."""
    inside = bright > 0
    if inside.all() or not inside.any():
        return 0.0
    return float(flat[inside].mean() - flat[~inside].mean())


def _face(outline: SingleArray, side: int) -> Face:
    (x, y), (width, height), turn = cv2.minAreaRect(outline)
    direction = math.radians(turn if width >= height else turn + 90.0)
    short, long = sorted(((width + 1.0) * M_PER_PX, (height + 1.0) * M_PER_PX))
    off = math.hypot(x - side // 2, y - side // 2) * M_PER_PX
    return Face(long, short, off, math.remainder(direction, math.pi))
