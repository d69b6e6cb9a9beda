"""Check that a part of a level surface looks plain in a picture: it is empty."""

from __future__ import annotations

import cv2
import numpy as np

from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

SMOOTHING_PX = 2.0
EDGE_GREY_PX = 7.0  # [grey/px] that the picture changes at an edge of something
MAX_EDGE_SHARE = 0.004  # of the part's pixels


def edge_share(
    image: ByteArray,
    camera: CameraModel,
    base_T_camera: Transform,
    corners: FloatArray,
    least_edge: float = EDGE_GREY_PX,
) -> float | None:
    """Return the share of pixels with edges, 0 to 1, in the picture of a part of a surface; None if the part
    is not completely visible.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        base_T_camera: (4, 4) pose of the camera.
        corners: (n, 3) corners of the convex part in the base frame, in [m].
        least_edge: change of the picture that counts as an edge, in [grey/px] after smoothing.
    """
    pixels = camera.project(apply(inverse(base_T_camera), corners))
    inside = (pixels >= 0.0) & (pixels <= np.array([camera.width, camera.height]) - 1.0)
    if not inside.all():
        return None
    mask = np.zeros(image.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.rint(pixels).astype(np.int32), 1)
    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), SMOOTHING_PX)
    across, down = (cv2.Sobel(smooth, cv2.CV_32F, *axes, scale=0.125) for axes in ((1, 0), (0, 1)))
    edges = np.hypot(across, down) > least_edge
    return float(edges[mask > 0].mean())


def is_plain(share: float | None) -> bool:
    """Return whether a part of a surface is completely visible and plain, given its share of pixels with
    edges.

    Args:
        share: result of `edge_share`, at most `MAX_EDGE_SHARE` for a plain part; None (not completely
            visible) gives False.
    """
    return share is not None and share <= MAX_EDGE_SHARE
