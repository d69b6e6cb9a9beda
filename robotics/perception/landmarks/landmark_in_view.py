"""Visibility of complete landmarks in a picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import BoolArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.constellation import Kind
from handcart.robotics.perception.landmarks.landmark import square_corners

RIM_PX = 16.0  # [px] of the picture in which a landmark may be, or not


def wholly_in_view(
    camera: CameraModel, base_T_camera: Transform, kind: Kind, places: Sequence[Pose2]
) -> BoolArray:
    """Return a mask (n,), True for landmarks that are completely in the picture, with a margin; occlusion is
    ignored.

    Args:
        camera: model of the camera.
        base_T_camera: (4, 4) pose of the camera.
        kind: side of the square landmarks, and height of the surface on which they lie.
        places: base_T_mark of each landmark, in [m] and [rad].
    """
    square = square_corners(kind.side)
    corners = np.array([apply(place.lift(kind.height), square) for place in places]).reshape(-1, 3)
    seen = apply(inverse(base_T_camera), corners)
    pixels, middle = camera.project(seen), np.array([camera.width - 1.0, camera.height - 1.0]) / 2
    inside = (np.abs(pixels - middle) <= middle - RIM_PX).all(axis=1)  # not where a pixel is NaN
    return np.asarray(inside.reshape(-1, 4).all(axis=1))
