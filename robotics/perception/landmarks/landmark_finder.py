"""Finding landmarks in an image."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.landmark import CELLS_ACROSS, Landmark, pattern, seen_landmark
from handcart.robotics.perception.landmarks.square_edges import fit_square

_SHRINK = 4  # candidates are looked for in an image that many times smaller
_WINDOWS = (51, 15)  # [px] of the small image; the small window is for a small landmark on a dark table
_DARKER = 10  # grey levels
_LEAST_SIDE = 9  # [px] of the small image
_SAMPLES = 2 * CELLS_ACROSS
_LIKELY, _CERTAIN = 0.6, 0.9  # correlation before and after the edges are fitted
_SQUARE = 0.04  # largest relative difference of the sides, and largest cosine between them


def find_landmarks(
    image: ByteArray,
    camera: CameraModel,
    side: float = 0.06,
    distances: tuple[float, float] = (0.0, np.inf),
) -> list[Landmark]:
    """Return the landmarks that are completely in an image, the one nearest to the optical axis first.

    A dark shape is a landmark if its edges are four straight lines after undistortion, if it is the picture
    of a square, and if its inside matches the landmark's pattern. A landmark of another size is only
    recognized by a wrong distance. Edges have to be at least 36 px long.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        side: side of a landmark, in [m].
        distances: least and largest accepted distance from the camera, in [m].
    """
    found: list[Landmark] = []
    for guess in _candidates(image):
        turned, score = _turn(image, guess)
        if score < _LIKELY or any(_same(seen, guess) for seen in found):
            continue
        fitted = fit_square(image, camera, turned)
        if fitted is None or not _is_square(fitted.rays, side, distances):
            continue
        seen = seen_landmark(fitted.rays, camera, score)
        turns, score = _correlate(image, seen.corners)
        if score >= _CERTAIN and turns == 0:
            found.append(seen._replace(score=score))
    return sorted(found, key=lambda seen: float(np.hypot(*seen.rays.mean(axis=0))))


def _candidates(image: ByteArray) -> list[FloatArray]:
    """Return corners (4, 2) in [px] of possible dark squares, clockwise as seen, good to some pixels."""
    size = image.shape[1] // _SHRINK, image.shape[0] // _SHRINK
    if min(size) < _LEAST_SIDE:
        return []
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
    scale = image.shape[1] / size[0], image.shape[0] / size[1]
    # Resizing keeps the outer rim of the pixels, not their centres.
    return [(guess + 0.5) * scale - 0.5 for window in _WINDOWS for guess in _quadrangles(small, window)]


def _quadrangles(small: ByteArray, window: int) -> list[FloatArray]:
    """Corners (4, 2), in [px] of the small image, of what is darker than the mean of a window around it."""
    dark = cv2.adaptiveThreshold(
        small, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV, window, _DARKER
    )
    outlines, _ = cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    guesses = []
    for outline in outlines:
        # OpenCV walks around holes the other way.
        if len(outline) < 4 or cv2.contourArea(outline, oriented=True) > -(_LEAST_SIDE**2) / 2:
            continue
        length = cv2.arcLength(outline, closed=True)
        corners = cv2.approxPolyDP(outline, 0.03 * length, closed=True)
        if len(corners) == 4 and cv2.isContourConvex(corners) and length >= 4 * _LEAST_SIDE:
            guesses.append(corners.reshape(4, 2).astype(np.float64)[::-1])
    return guesses


def _same(seen: Landmark, guess: FloatArray) -> bool:
    return bool(np.abs(guess.mean(axis=0) - seen.centre).max() < _SHRINK * _LEAST_SIDE / 2)


def _turn(image: ByteArray, corners: FloatArray) -> tuple[FloatArray, float]:
    """Return the corners (4, 2) from the landmark's upper left one on, clockwise, and the correlation."""
    turns, score = _correlate(image, corners)
    return np.roll(corners, -turns, axis=0), score


def _correlate(image: ByteArray, corners: FloatArray) -> tuple[int, float]:
    """Return the index of the upper left corner, and the correlation of the inside with the pattern."""
    rim = np.array([[0, 0], [_SAMPLES, 0], [_SAMPLES, _SAMPLES], [0, _SAMPLES]]) - 0.5
    to_image = cv2.getPerspectiveTransform(rim.astype(np.float32), corners.astype(np.float32))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    inside = cv2.warpPerspective(image, to_image, (_SAMPLES, _SAMPLES), flags=flags).astype(np.float64)
    inside -= inside.mean()
    size = float(np.linalg.norm(inside))
    if size < _SAMPLES:  # a grey level each: there is nothing to be seen
        return 0, 0.0
    scores = _templates() @ inside.ravel() / size
    turns = int(np.argmax(scores))
    return turns, float(scores[turns])


@cache
def _templates() -> FloatArray:
    """Return the pattern, unit length (4, n), with its upper left corner at corner 0, 1, 2, 3."""
    fields = np.kron(pattern() - pattern().mean(), np.ones((2, 2)))
    fields /= np.linalg.norm(fields)
    return np.array([np.rot90(fields, -turns).ravel() for turns in range(4)])


def _is_square(rays: FloatArray, side: float, distances: tuple[float, float]) -> bool:
    """Return True if a square in space can look like that, at an accepted distance.

    The columns of the homography from the square to rays are two directions of space, of the same length
    and at right angles (Zhang, 2000, eq. 3 and 4).
    """
    unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32) - np.float32(0.5)
    H = cv2.getPerspectiveTransform(unit, rays.astype(np.float32))
    right, down = H[:, 0], H[:, 1]
    lengths = float(np.linalg.norm(right)), float(np.linalg.norm(down))
    if abs(lengths[0] / lengths[1] - 1.0) > _SQUARE or abs(right @ down) > _SQUARE * lengths[0] * lengths[1]:
        return False
    distance = side * float(np.linalg.norm(H[:, 2])) / float(np.mean(lengths))
    return distances[0] <= distance <= distances[1]
