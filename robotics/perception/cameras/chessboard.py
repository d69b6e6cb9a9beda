"""A plain chessboard."""

from __future__ import annotations

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray, SingleArray
from handcart.robotics.perception.cameras.calibration_board import BoardView, CalibrationBoard

_FLAGS = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ADAPTIVE_THRESH
_SHARE = 0.25  # of the distance between two corners that is looked at about each: more, and others disturb
_OFF_PX, _OFF = 0.5, 5.0  # [px], medians that a corner may be beside the smooth grid
_WINDOW = (2, 5)  # [px] that is looked at to each side, at least and at most


class Chessboard(CalibrationBoard):
    """Chessboard for calibrating a camera, which has to be completely in the image.

    Its upper left square is black; if the square at the opposite corner is white, the board's orientation is
    known by that. A corner is refined to the point to which all gradients around it are perpendicular
    (Förstner and Gülch, 1987). If columns plus rows is even, the board looks the same after half a turn, so
    that its pose may be wrong by half a turn. Such a board can calibrate the lens, but not the camera's pose
    on the robot.
    """

    def __init__(self, columns: int, rows: int, square: float) -> None:
        """Create a board of `columns` by `rows` squares, not inner corners, with sides of `square` [m]."""
        super().__init__(columns, rows, square)
        self._inner = (columns - 1, rows - 1)

    def find(self, image: ByteArray) -> BoardView | None:
        """Return the board's corners in a grey image (h, w); None if the board is not completely visible."""
        found, rough = cv2.findChessboardCorners(image, self._inner, flags=_FLAGS)
        if not found:
            return None
        corners = _refined(image, np.asarray(rough, np.float32).reshape(self._inner[1], self._inner[0], 2))
        if _upper_left_is_white(image, corners):
            corners = corners[::-1, ::-1]
        sound = _sound(corners).ravel()
        return BoardView(self._places(np.flatnonzero(sound)), corners.reshape(-1, 2)[sound])

    def _drawn(self, width: int, height: int) -> ByteArray:
        columns, rows = self._inner[0] + 1, self._inner[1] + 1
        column = np.arange(width) * columns // width
        row = np.arange(height) * rows // height
        return np.where((row[:, None] + column) % 2, np.uint8(255), np.uint8(0))


def _refined(image: ByteArray, rough: SingleArray) -> FloatArray:
    """Corners (rows, columns, 2) to a fraction of a pixel."""
    steps = [np.linalg.norm(np.diff(rough, axis=axis), axis=2).min() for axis in (0, 1)]
    window = int(np.clip(_SHARE * min(steps), *_WINDOW))
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-4)
    fine = cv2.cornerSubPix(image, rough.reshape(-1, 1, 2), (window, window), (-1, -1), criteria)
    return fine.reshape(rough.shape).astype(np.float64)


def _sound(corners: FloatArray) -> BoolArray:
    """Return True for corners (rows, columns, 2) that agree with the others, undisturbed by their
    surroundings.

    A lens and a plane seen at a slant make a smooth grid, here a polynomial of third degree.
    """
    rows, columns = np.indices(corners.shape[:2]) / np.reshape(corners.shape[:2], (2, 1, 1))
    terms = [columns**i * rows**j for i in range(4) for j in range(4 - i)]
    basis = np.stack(terms, axis=-1).reshape(-1, len(terms))
    places = corners.reshape(-1, 2)
    fit = basis @ np.linalg.lstsq(basis, places, rcond=None)[0]
    off = np.linalg.norm(places - fit, axis=1)
    return np.asarray(off < max(_OFF_PX, _OFF * float(np.median(off))))


def _upper_left_is_white(image: ByteArray, corners: FloatArray) -> bool:
    """Return True if the square before the first corner (rows, columns, 2) is brighter than its neighbour."""
    first, right, down = corners[0, 0], corners[0, 1] - corners[0, 0], corners[1, 0] - corners[0, 0]
    outer, beside = first - 0.5 * right - 0.5 * down, first + 0.5 * right - 0.5 * down
    sheet = np.array([outer, beside], dtype=np.float32)
    greys = cv2.remap(image, sheet[None, :, 0], sheet[None, :, 1], cv2.INTER_LINEAR)
    return bool(greys[0, 0] > greys[0, 1])
