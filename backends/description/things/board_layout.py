"""Pattern of a calibration board in a file."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.files.models.model import FileModel
from handcart.robotics.perception.cameras.calibration_board import CalibrationBoard
from handcart.robotics.perception.cameras.chessboard import Chessboard
from handcart.robotics.perception.landmarks.charuco_board import CharucoBoard
from handcart.robotics.perception.landmarks.tag_family import DEFAULT_FAMILY, TagFamily

Squares = Annotated[int, Field(ge=3, le=50)]


class BoardLayout(FileModel):
    """Layout of a chessboard, or ChArUco board (tags in the white squares), for camera calibration."""

    pattern: Literal["charuco", "chessboard"] = "charuco"
    columns: Squares = 9
    """Number of squares in a row; inner corners are one fewer."""
    rows: Squares = 6
    tag_mm: Annotated[float, Field(gt=0.0)] | None = None
    """Side of a tag (default: three quarters of the side of a square)."""
    tags: TagFamily = DEFAULT_FAMILY

    @model_validator(mode="after")
    def _distinct_sides(self) -> Self:
        if self.pattern == "chessboard" and (self.columns + self.rows) % 2 == 0:
            raise ValueError(
                f"a chessboard of {self.columns} by {self.rows} squares looks the same from both sides; "
                "allowed: one number even, one odd"
            )
        return self

    def board(self, square_mm: float) -> CalibrationBoard:
        """Return the calibration board with squares of side `square_mm`.

        Raises:
            ValueError: the tags do not fit into the squares.
        """
        square = square_mm / 1e3
        if self.pattern == "chessboard":
            return Chessboard(self.columns, self.rows, square)
        tag = None if self.tag_mm is None else self.tag_mm / 1e3
        return CharucoBoard(self.columns, self.rows, square, tag, self.tags)
