"""The board that cameras are calibrated with: a chessboard with tags in its white fields (ChArUco)."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from robotics.perception.camera_model import Floats, GreyImage

_FEWEST_CORNERS = 6


class BoardView(NamedTuple):
    """Corners of the board in one image."""

    points: Floats
    """(n, 3) in [m] of the board's frame: origin in the middle, x to the right, y up, z out of it."""
    pixels: Floats
    """(n, 2) where they are seen, in [px]."""


def calibration_board(square: float) -> CalibrationBoard:
    """The usual board, 9 by 6 squares with sides of `square` [m], its tags three quarters of that."""
    return CalibrationBoard(square=square, tag=0.75 * square)


class CalibrationBoard:
    """A ChArUco board; `draw` it, print it, glue it on something flat.

    Every corner is told by the tags around it, so the board may lie in any direction and stick out of the
    image.
    """

    def __init__(self, columns: int = 9, rows: int = 6, square: float = 0.02, tag: float = 0.015) -> None:
        """`columns` by `rows` squares with sides of `square` [m], each white one with a tag of `tag` [m]."""
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_250)
        self._board = cv2.aruco.CharucoBoard((columns, rows), square, tag, dictionary)
        self._size = np.array([columns, rows]) * square
        self._columns = columns
        self._square = square
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.CharucoDetector(self._board, detectorParams=parameters)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in [m]."""
        return float(self._size[0]), float(self._size[1])

    def draw(self, m_per_px: float = 1.25e-4) -> GreyImage:
        """Grey image (h, w) to print with `m_per_px` [m] a pixel, without a margin."""
        width, height = np.rint(self._size / m_per_px).astype(int).tolist()
        return np.asarray(self._board.generateImage((width, height)), dtype=np.uint8)

    def find(self, image: GreyImage) -> BoardView | None:
        """The corners in an image (h, w), or None where there are fewer than six."""
        pixels, ids, _, _ = self._detector.detectBoard(image)
        if ids is None or len(ids) < _FEWEST_CORNERS:
            return None
        return BoardView(self._places(np.ravel(ids)), np.asarray(pixels, dtype=np.float64).reshape(-1, 2))

    def _places(self, ids: np.ndarray[tuple[int, ...], np.dtype[np.integer]]) -> Floats:
        """(n, 3): OpenCV counts corners row by row from the upper left."""
        row, column = np.divmod(ids, self._columns - 1)
        x = (column + 1) * self._square - self._size[0] / 2
        y = self._size[1] / 2 - (row + 1) * self._square
        return np.column_stack([x, y, np.zeros(len(ids))])
