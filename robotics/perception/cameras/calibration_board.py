"""Common interface of all boards for camera calibration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.numerics.arrays import ByteArray, FloatArray


class BoardView(NamedTuple):
    """Corners of a calibration board that were found in one image, with their positions on the board."""

    points: FloatArray
    """(n, 3) of the corners in the board's frame in [m]; origin in the middle, x right, y up, z out of it."""
    pixels: FloatArray
    """(n, 2) of the same corners in the image, column and row in [px]."""


class CalibrationBoard(ABC):
    """Base class of calibration boards, flat patterns of squares whose corners are found in images."""

    def __init__(self, columns: int, rows: int, square: float) -> None:
        """Create a board of `columns` by `rows` squares with sides of `square` [m]."""
        self._columns, self._square = columns, square
        self._size = np.array([columns, rows]) * square
        self.corners = (columns - 1) * (rows - 1)
        """Number of inner corners, the most that can be seen."""

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the printed board, in [m]."""
        return float(self._size[0]), float(self._size[1])

    def draw(self, m_per_px: float = 1.25e-4) -> ByteArray:
        """Return the board as a grey image (h, w) for printing, without a margin.

        Args:
            m_per_px: size of a pixel, in [m].
        """
        width, height = np.rint(self._size / m_per_px).astype(int).tolist()
        return self._drawn(width, height)

    @abstractmethod
    def find(self, image: ByteArray) -> BoardView | None:
        """Return the board's corners in a grey image (h, w); None if too few are visible to identify the
        board.
        """

    @abstractmethod
    def _drawn(self, width: int, height: int) -> ByteArray:
        """Return the pattern (height, width), in [px]."""

    def _places(self, numbers: NDArray[np.integer]) -> FloatArray:
        """Return the positions (n, 3) in [m] of corners by their number, row by row from the upper left."""
        row, column = np.divmod(numbers, self._columns - 1)
        x = (column + 1) * self._square - self._size[0] / 2
        y = self._size[1] / 2 - (row + 1) * self._square
        return np.column_stack([x, y, np.zeros(len(numbers))])
