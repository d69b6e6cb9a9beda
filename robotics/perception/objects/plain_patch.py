"""Check that a part of a level surface looks plain in a picture: it is empty."""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import cv2
import numpy as np

from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray, SingleArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

SMOOTHING_PX = 2.0
FALSE_ALARM_RATE = 1e-6  # of plain parts in which a pixel counts as an edge because of noise
MIN_EDGE_GREY_PX = 1.0  # [grey/px] of an edge of 5 grey levels: uneven light changes a picture by less
MAX_EDGE_GREY_PX = 7.0  # [grey/px] of an edge of 35 grey levels, which is one at any noise
MAX_EDGE_SHARE = 0.004  # of the part's pixels
_STEP_PX = 4  # between pixels at which noise is measured: at nearer ones a smoothed gradient is alike
_TILE_STEPS = 20  # side of the parts in which noise is measured
_CALM_SHARE = 0.25  # of these parts that show nothing but noise
_SIGMAS_PER_MAD = 1.4826  # of a normal distribution


class PictureEdges(NamedTuple):
    """How much a grey picture changes at each pixel, and how much it would by noise alone."""

    changes: SingleArray
    """(h, w) length of the smoothed picture's gradient, in [grey/px]."""
    noise: float
    """Standard deviation of a component of that gradient in plain parts of the picture, in [grey/px]."""

    @classmethod
    def of_picture(cls, image: ByteArray) -> Self:
        """Measure the edges of a picture (h, w), grey, and its noise."""
        smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), SMOOTHING_PX)
        across, down = (
            np.asarray(cv2.Sobel(smooth, cv2.CV_32F, *axes, scale=0.125), dtype=np.float32)
            for axes in ((1, 0), (0, 1))
        )
        return cls(np.hypot(across, down), max(_noise(across), _noise(down)))

    def least_edge(self, pixels: int) -> float:
        """Return the change, in [grey/px], that counts as an edge in a part of so many pixels.

        In a plain part, noise reaches it at one of the pixels with a probability of `FALSE_ALARM_RATE` at
        most: the length of a gradient of normal noise has a Rayleigh distribution.
        """
        sigmas = math.sqrt(2.0 * math.log(max(1, pixels) / FALSE_ALARM_RATE))
        return min(MAX_EDGE_GREY_PX, max(MIN_EDGE_GREY_PX, sigmas * self.noise))

    def share(self, camera: CameraModel, base_T_camera: Transform, corners: FloatArray) -> float | None:
        """Return the share of pixels with edges, 0 to 1, in the picture of a part of a surface; None if the
        part is not completely visible.

        Args:
            camera: model of the camera.
            base_T_camera: (4, 4) pose of the camera.
            corners: (n, 3) corners of the convex part in the base frame, in [m].
        """
        inside = self._inside(camera.project(apply(inverse(base_T_camera), corners)))
        if inside is None:
            return None
        changes = self.changes[inside]
        return float((changes > self.least_edge(len(changes))).mean())

    def _inside(self, pixels: FloatArray) -> BoolArray | None:
        """Return a mask (h, w) of the pixels within corners (n, 2); None if one is out of the picture."""
        height, width = self.changes.shape
        if not ((pixels >= 0.0) & (pixels <= np.array([width, height]) - 1.0)).all():
            return None
        mask = np.zeros((height, width), np.uint8)
        cv2.fillConvexPoly(mask, np.rint(pixels).astype(np.int32), 1)
        return mask > 0


def is_plain(share: float | None) -> bool:
    """Return whether a part of a surface is completely visible and plain, given its share of pixels with
    edges.

    Args:
        share: result of `PictureEdges.share`, at most `MAX_EDGE_SHARE` for a plain part; None (not completely
            visible) gives False.
    """
    return share is not None and share <= MAX_EDGE_SHARE


def _noise(gradient: SingleArray) -> float:
    """Return the standard deviation of a gradient's component (h, w) in the calmest parts of a picture.

    It is measured by the median absolute deviation of each part, at the scale at which edges are found: that
    noise of neighbouring pixels may be alike, as after compression, needs no assumption.
    """
    side = _STEP_PX * _TILE_STEPS
    rows, columns = (size // side for size in gradient.shape)
    tiles = gradient[: rows * side : _STEP_PX, : columns * side : _STEP_PX]
    tiles = tiles.reshape(rows, _TILE_STEPS, columns, _TILE_STEPS).swapaxes(1, 2).reshape(rows * columns, -1)
    if not len(tiles):  # a picture smaller than a part
        tiles = gradient.reshape(1, -1)
    spread = np.median(np.abs(tiles - np.median(tiles, axis=1, keepdims=True)), axis=1)
    return _SIGMAS_PER_MAD * float(np.quantile(spread, _CALM_SHARE))
