"""Marks in a world's file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from handcart.backends.description.things.board_layout import BoardLayout
from handcart.backends.simulation.world.world_file import FloorPose
from handcart.files.models.model import FileModel


class MarkSpec(FloorPose):
    """Printed sheet on a level surface, such as a landmark; its pose is that of its middle."""

    kind: Literal["landmark", "square", "disc", "frame", "board"] = "landmark"
    """Landmark, decoy, or board to calibrate cameras with."""
    height_m: Annotated[float, Field(ge=0.0, le=3.0)]
    """Height of the surface."""
    size_mm: Annotated[float, Field(gt=0.0, le=500.0)] = 60.0
    """Side of the mark; of a board, the side of one of its squares."""
    board: BoardLayout = BoardLayout()
    """A board's pattern."""


class MarksSection(FileModel):
    """Section of a world's file that lists printed sheets, such as landmarks and calibration boards."""

    marks: tuple[MarkSpec, ...] = ()
