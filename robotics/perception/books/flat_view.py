"""The front of a shelf drawn flat."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel, picture_of_plane

_M_PER_PX = 0.0005
_WIDEST_VIEW = 1.5  # [m]


class FlatView(NamedTuple):
    """View of the shelf's front plane as if seen straight from the front, without perspective.

    `picture` (h, w) is grey, and `seen` (h, w) is True where the image shows the front. Column c and row r
    show y = left - c * m_per_px and z = top - r * m_per_px in the shelf frame (x into the shelf, y to the
    left, z up), in [m].
    """

    picture: ByteArray
    seen: BoolArray
    left: float
    top: float
    m_per_px: float


def flat_view(
    image: ByteArray,
    camera: CameraModel,
    camera_T_shelf: FloatArray,
    mask: BoolArray | None,
    m_per_px: float = _M_PER_PX,
    heights: tuple[float, float] | None = None,
) -> FlatView:
    """Return the part of the shelf's plane x = 0 that an image shows, without lens distortion and slant.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        camera_T_shelf: (4, 4) pose of the shelf, translation in [m].
        mask: (h, w) True where the image shows the shelf (False: a held book hides it); None: everywhere.
        m_per_px: size of a pixel of the view, in [m].
        heights: least and largest z that is shown, in the shelf frame, in [m]; None: all.

    Raises:
        ValueError: the camera doesn't look at the shelf's front.
    """
    stops = np.array([0.0, 0.5, 1.0])
    # The view bulges: the middles of its sides are as far out as its corners.
    across, down = np.meshgrid(stops * (camera.width - 1), stops * (camera.height - 1))
    points = camera.pixel_on_plane(np.column_stack([across.ravel(), down.ravel()]), camera_T_shelf)
    low, high = points.min(axis=0), points.max(axis=0)
    if not np.isfinite(points).all() or (high - low).max() > _WIDEST_VIEW:
        raise ValueError("the camera doesn't look at the shelf's front")
    bottom, top = (low[1], high[1]) if heights is None else heights
    size = (int((high[0] - low[0]) / m_per_px) + 1, int((top - bottom) / m_per_px) + 1)
    homography = picture_of_plane(camera_T_shelf, (high[0], top), m_per_px)
    shown = (
        np.full(image.shape, 255, dtype=np.uint8) if mask is None else mask.astype(np.uint8) * np.uint8(255)
    )
    seen = camera.rectify(shown, homography, size) > 250
    return FlatView(camera.rectify(image, homography, size), seen, float(high[0]), float(top), m_per_px)
