"""A chessboard with tags in its white fields (ChArUco)."""

from __future__ import annotations

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.cameras.calibration_board import BoardView, CalibrationBoard
from handcart.robotics.perception.landmarks.tag_family import DEFAULT_FAMILY, TagFamily, dictionary, tags_of

TAG_SHARE = 0.75  # of a square's side (default)
_FEWEST_CORNERS = 6


class CharucoBoard(CalibrationBoard):
    """Calibration board whose corners are identified by tags in its squares (ChArUco).

    A part of the board in the image is enough, in any orientation.
    """

    def __init__(
        self,
        columns: int = 9,
        rows: int = 6,
        square: float = 0.02,
        tag: float | None = None,
        family: TagFamily = DEFAULT_FAMILY,
    ) -> None:
        """Create a board whose white squares each hold a tag.

        Args:
            columns: number of squares along x.
            rows: number of squares along y.
            square: side of a square, in [m].
            tag: side of a tag, in [m]; None: `TAG_SHARE` of `square`.
            family: family of the tags.

        Raises:
            ValueError: the tag doesn't fit its square, or the family has too few tags.
        """
        super().__init__(columns, rows, square)
        tag = TAG_SHARE * square if tag is None else tag
        if not 0.0 < tag < square:
            raise ValueError(f"a tag of {1e3 * tag:g} mm doesn't fit a square of {1e3 * square:g} mm")
        if columns * rows // 2 > tags_of(family):
            raise ValueError(
                f"the board needs {columns * rows // 2} tags, the family {family} has {tags_of(family)}"
            )
        self._board = cv2.aruco.CharucoBoard((columns, rows), square, tag, dictionary(family))
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.CharucoDetector(self._board, detectorParams=parameters)

    def find(self, image: ByteArray) -> BoardView | None:
        """Return the board's visible corners in a grey image (h, w); None if there are fewer than six."""
        pixels, ids, _, _ = self._detector.detectBoard(image)
        if ids is None or len(ids) < _FEWEST_CORNERS:
            return None
        return BoardView(self._places(np.ravel(ids)), np.asarray(pixels, dtype=np.float64).reshape(-1, 2))

    def _drawn(self, width: int, height: int) -> ByteArray:
        return np.asarray(self._board.generateImage((width, height)), dtype=np.uint8)
