"""A picture of an ideal pinhole camera, painted from far to near."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray, SingleArray

_NEAREST = 0.01  # surfaces nearer to the camera are not drawn [m]
_SHIFT = 4  # OpenCV draws to 1/16 px
_FAR = 30000.0  # beyond any picture, within OpenCV's fixed-point range [px]

Shade = Callable[[ByteArray], ByteArray]


class Canvas:
    """Grey picture of a pinhole camera on which faces given in the world are painted; an integer pixel is a
    pixel's centre.
    """

    def __init__(
        self, K: FloatArray, size: tuple[int, int], world_T_camera: Transform, background: int
    ) -> None:
        """Begin with a picture of one grey.

        Args:
            K: (3, 3) camera matrix, in [px].
            size: width and height in [px].
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            background: grey of the empty picture, 0 to 255.
        """
        self.picture: ByteArray = np.full((size[1], size[0]), background, dtype=np.uint8)
        self.eye: FloatArray = world_T_camera[:3, 3]
        self._K = K
        self._turn = world_T_camera[:3, :3]
        self._projection = K @ self._turn.T

    def seen_from_front(self, corner: FloatArray, normal: FloatArray) -> bool:
        """Return whether the camera sees the front of a flat face, the side to which the normal points.

        Args:
            corner: (3,) any point of the face in the world, in [m].
            normal: (3,) normal of the face in the world, of any length.
        """
        return bool((self.eye - corner) @ normal > 0.0)

    def shows_none(self, corners: FloatArray) -> bool:
        """Return whether a convex body is surely outside the picture.

        Args:
            corners: (n, 3) in the world, in [m].
        """
        rays = (corners - self.eye) @ self._projection.T
        return not (rays[:, 2] < _NEAREST).any() and self._outside(rays[:, :2] / rays[:, 2:])

    def rectangles(self, corners: FloatArray) -> FloatArray:
        """Return the rectangle of the picture, with what is beyond its edges, that each body is within.

        It is infinite if a part of the body is beside or behind the camera, and empty (least columns and rows
        above the largest) if all of it is, or if the body is outside the picture.

        Args:
            corners: (n, k, 3) corners of convex bodies in the world, in [m].

        Returns:
            (n, 4) least column and row, largest column and row, in [px].
        """
        rays = (corners - self.eye) @ self._projection.T
        ahead = rays[:, :, 2] >= _NEAREST
        pixels = rays[:, :, :2] / np.where(ahead, rays[:, :, 2], 1.0)[:, :, None]
        low, high = pixels.min(axis=1), pixels.max(axis=1)
        low[~ahead.all(axis=1)], high[~ahead.all(axis=1)] = -np.inf, np.inf
        edge = np.array(self.picture.shape[::-1]) - 1
        unseen = ~ahead.any(axis=1) | (high < 0).any(axis=1) | (low > edge).any(axis=1)
        low[unseen], high[unseen] = np.inf, -np.inf
        return np.hstack((low, high))

    def polygon(self, corners: FloatArray, grey: int) -> None:
        """Paint a flat convex face in one grey.

        Args:
            corners: (n, 3) in the world, in [m].
            grey: 0 to 255.
        """
        rays = (corners - self.eye) @ self._projection.T
        if (rays[:, 2] < _NEAREST).any():
            rays = _before(rays)
            if len(rays) < 3:
                return
        pixels = rays[:, :2] / rays[:, 2:]
        if self._outside(pixels):
            return
        fixed = np.rint(np.clip(pixels, -_FAR, _FAR) * 2**_SHIFT).astype(np.int32)
        cv2.fillConvexPoly(self.picture, fixed, grey, cv2.LINE_AA, _SHIFT)

    def texture(
        self, levels: Sequence[tuple[ByteArray, float]], face: Transform, shade: Shade | None = None
    ) -> None:
        """Draw a printed face.

        Args:
            levels: the picture (h, w) at full resolution and halved several times, each level with the size
                of its pixels, in [m].
            face: (4, 4) pose in the world: origin at the picture's upper left corner, x along its rows, y
                down its columns.
            shade: function that changes the greys of the picture by the light on it; None: no change.
        """
        size = np.array([levels[0][0].shape[1], levels[0][0].shape[0]]) * levels[0][1]
        corners = face[:3, 3] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size @ face[:3, :2].T
        rays = (corners - self.eye) @ self._projection.T
        is_cut = bool((rays[:, 2] < _NEAREST).any())
        if is_cut and len(rays := _before(rays)) < 3:
            return
        pixels = rays[:, :2] / rays[:, 2:]
        if self._outside(pixels):
            return
        picture, metres = levels[0] if is_cut else self._level(levels, pixels, size)
        self._warp(picture if shade is None else shade(picture), metres, face, pixels)

    def _level(
        self, levels: Sequence[tuple[ByteArray, float]], pixels: FloatArray, size: FloatArray
    ) -> tuple[ByteArray, float]:
        """Return the coarsest level, with the size of its pixels in [m], that is as fine as the picture shows
        it.

        Args:
            levels: the same picture (h, w) in falling resolution, each with the size of a pixel, in [m].
            pixels: (4, 2) columns and rows of the face's corners in the camera's picture, from its upper
                left, clockwise.
            size: (2,) width and height of the face, in [m].
        """
        px_per_m = max(
            np.linalg.norm(pixels[1] - pixels[0]) / size[0], np.linalg.norm(pixels[3] - pixels[0]) / size[1]
        )
        fine = [level for level in levels if level[1] * px_per_m <= 1.0]
        return fine[-1] if fine else levels[0]

    def _warp(self, picture: ByteArray, metres: float, face: Transform, pixels: FloatArray) -> None:
        height, width = self.picture.shape
        left, top = (int(item) for item in np.maximum(np.floor(pixels.min(axis=0)) - 1, 0))
        right, bottom = (int(item) for item in np.minimum(np.ceil(pixels.max(axis=0)) + 2, (width, height)))
        # A picture's pixel (column, row) has its centre half a pixel in.
        to_metres = np.array([[metres, 0.0, metres / 2], [0.0, metres, metres / 2], [0.0, 0.0, 1.0]])
        plane = np.column_stack((face[:3, 0], face[:3, 1], face[:3, 3] - self.eye))
        to_window = np.array([[1.0, 0.0, -left], [0.0, 1.0, -top], [0.0, 0.0, 1.0]])
        homography = to_window @ self._projection @ plane @ to_metres
        window = (right - left, bottom - top)
        warped = cv2.warpPerspective(
            picture, homography, window, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        target = self.picture[top:bottom, left:right]
        cover = _cover(pixels - (left, top), window)
        np.copyto(target, _blend(target, warped.astype(np.uint8, copy=False), cover))

    def _outside(self, pixels: FloatArray) -> bool:
        height, width = self.picture.shape
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        return bool(high[0] < 0 or high[1] < 0 or low[0] > width - 1 or low[1] > height - 1)


def _cover(pixels: FloatArray, window: tuple[int, int]) -> SingleArray:
    """Return the share (h, w), 0 to 1, of each pixel that a convex polygon covers: distance to its edges +
    1/2.

    Args:
        pixels: (n, 2) columns and rows of its corners, in order.
        window: width and height of the window, in [px].
    """
    columns = np.arange(window[0], dtype=np.float32)
    rows = np.arange(window[1], dtype=np.float32)[:, None]
    cover = np.ones((window[1], window[0]), dtype=np.float32)
    area = _area(pixels)
    for a, b in zip(pixels, np.roll(pixels, -1, axis=0), strict=True):
        along = (b - a) / max(1e-9, float(np.hypot(*(b - a)))) * np.sign(area)
        inside = np.float32(along[0]) * (rows - np.float32(a[1])) - np.float32(along[1]) * (
            columns - np.float32(a[0])
        )
        np.minimum(cover, inside + np.float32(0.5), out=cover)
    return np.maximum(cover, 0.0, out=cover)


def _area(pixels: FloatArray) -> float:
    x, y = pixels[:, 0], pixels[:, 1]
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _blend(below: ByteArray, above: ByteArray, cover: SingleArray) -> ByteArray:
    mixed = below + (above.astype(np.float32) - below) * cover
    return (mixed + np.float32(0.5)).astype(np.uint8)


def _before(rays: FloatArray) -> FloatArray:
    """Return the corners (m, 3) of the part of a polygon that is beyond the nearest plane (Sutherland and
    Hodgman, 1974).

    Args:
        rays: (n, 3) corners in the optical frame, in [m].
    """
    corners: list[list[float]] = rays.tolist()
    kept: list[list[float]] = []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        if a[2] >= _NEAREST:
            kept.append(a)
        if (a[2] >= _NEAREST) != (b[2] >= _NEAREST):
            share = (_NEAREST - a[2]) / (b[2] - a[2])
            kept.append([one + share * (other - one) for one, other in zip(a, b, strict=True)])
    return np.array(kept).reshape(-1, 3)
