"""The four edges of a dark square, by line fits through edge points to a fraction of a pixel."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

_POINTS = 40  # on each edge
_ENDS = 0.08  # of an edge that is skipped at each end: the blurred corners
_COARSE_REACH, _FINE_REACH, _FINE_STEP = 9, 4.0, 0.5  # on each side of an edge [px]
_LEVEL = 4  # samples at each end of a profile that define dark and bright
_LEAST_CONTRAST = 35.0  # grey levels
_LEAST_FOUND = 0.85  # of an edge's points
_STRAIGHT = 0.3  # [px] rms of a straight edge
_HUBER = 0.15  # [px]


class SquareEdges(NamedTuple):
    """Corners of a square that was fitted to an image.

    The corners (4, 2) are given as rays (x/z, y/z), in the order of the guessed corners from which the fit
    started. `rms`, in [px], is the root mean square error of the fitted edges.
    """

    rays: FloatArray
    rms: float


def fit_square(image: ByteArray, camera: CameraModel, guess: FloatArray) -> SquareEdges | None:
    """Return the dark square whose corners are near guessed ones; None if it is not found.

    Each edge must be completely in the image, straight after correction of the lens, and dark on its inner
    side. The edge points are undistorted instead of the image, which would have to be interpolated once more.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        guess: (4, 2) column and row of the corners, clockwise as seen, at most 8 px off, in [px].
    """
    ends = _coarse_corners(image, camera, guess)
    return None if ends is None else _fine(image, camera, ends)


def _coarse_corners(image: ByteArray, camera: CameraModel, guess: FloatArray) -> FloatArray | None:
    """Corners (4, 2) as rays, good to a pixel: lines through the steepest rise of each profile."""
    points, outward = _along_edges(guess)
    offsets = np.arange(-_COARSE_REACH, _COARSE_REACH + 1.0)
    profiles = _profiles(image, points, outward, offsets)
    rise = profiles[..., 2:] - profiles[..., :-2]
    steepest = rise.argmax(axis=-1)
    found = rise.max(axis=-1) > _LEAST_CONTRAST / 2
    if (found.mean(axis=1) < _LEAST_FOUND).any():
        return None
    edge = points + outward * offsets[1:-1][steepest][..., None]
    fitted = _lines(camera, edge, found, 1.0)
    return None if fitted is None else _corners(fitted[0])


def _fine(image: ByteArray, camera: CameraModel, corners: FloatArray) -> SquareEdges | None:
    ideal, _ = _along_edges(corners)
    rays = ideal.reshape(-1, 2)
    points = camera.project(np.column_stack([rays, np.ones(len(rays))])).reshape(4, -1, 2)
    height, width = image.shape
    if points.min() < 1.0 or points[..., 0].max() > width - 2.0 or points[..., 1].max() > height - 2.0:
        return None
    along = np.gradient(points, axis=1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    outward = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    offsets = np.arange(-_FINE_REACH, _FINE_REACH + _FINE_STEP / 2, _FINE_STEP)
    profiles = _profiles(image, points, outward, offsets)
    dark, bright = profiles[..., :_LEVEL].mean(axis=-1), profiles[..., -_LEVEL:].mean(axis=-1)
    contrast = bright - dark
    # The area above the profile gives the position of a step of the same levels: blur does not shift it.
    # Trapezoids: the samples at both ends count half.
    area = profiles.sum(axis=-1) - 0.5 * (profiles[..., 0] + profiles[..., -1]) - dark * (len(offsets) - 1)
    away = _FINE_REACH - _FINE_STEP * area / np.maximum(contrast, 1.0)
    found = (contrast > _LEAST_CONTRAST) & (np.abs(away) < _FINE_REACH / 2)
    if (found.mean(axis=1) < _LEAST_FOUND).any():
        return None
    fitted = _lines(camera, points + outward * away[..., None], found, _HUBER)
    if fitted is None or fitted[1] > _STRAIGHT:
        return None
    return SquareEdges(_corners(fitted[0]), fitted[1])


def _along_edges(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (4, n, 2) along the edges, and the directions (4, 1, 2) out of the quadrangle."""
    share = np.linspace(_ENDS, 1.0 - _ENDS, _POINTS)[:, None]
    edges = np.roll(corners, -1, axis=0) - corners
    along = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    outward = np.column_stack([along[:, 1], -along[:, 0]])
    return corners[:, None] + share * edges[:, None], outward[:, None]


def _profiles(image: ByteArray, points: FloatArray, outward: FloatArray, offsets: FloatArray) -> FloatArray:
    """Greys (4, n, m) across each edge, from inside to outside."""
    at = points[..., None, :] + outward[..., None, :] * offsets[:, None]
    x, y = (at[..., i].reshape(-1, len(offsets)).astype(np.float32) for i in (0, 1))
    sampled = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return sampled.reshape(at.shape[:-1]).astype(np.float64)


def _lines(
    camera: CameraModel,
    points: FloatArray,
    found: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    huber: float,
) -> tuple[FloatArray, float] | None:
    """Lines (4, 3), a x + b y + c = 0 of rays, through pixels (4, n, 2), and the largest rms in [px]."""
    rays = camera.undistort(points.reshape(-1, 2)).reshape(points.shape)
    focal = float(camera.K[0, 0])
    lines, rms = np.empty((4, 3)), 0.0
    for i in range(4):
        on_edge = rays[i][found[i]]
        middle = on_edge.mean(axis=0)
        centred = ((on_edge - middle) * focal).astype(np.float32)
        dx, dy, x, y = cv2.fitLine(centred, cv2.DIST_HUBER, huber, 1e-4, 1e-5).ravel().tolist()
        lines[i] = dy, -dx, dx * (middle[1] + y / focal) - dy * (middle[0] + x / focal)
        rms = max(rms, focal * float(np.sqrt(np.mean((on_edge @ lines[i, :2] + lines[i, 2]) ** 2))))
    return (lines, rms) if np.isfinite(lines).all() else None


def _corners(lines: FloatArray) -> FloatArray:
    """Corners (4, 2): each the meeting of an edge with the one before it."""
    meet = np.cross(np.roll(lines, 1, axis=0), lines)
    return np.asarray(meet[:, :2] / meet[:, 2:])
