"""Drawing of a wall: rows, supply and tables; the order of the work is not part of it."""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.robotics.geometry.pose2 import Pose2

from .building import BlockPlace, Positive, Table


class DrawnStart(FileModel):
    """Start pose of the base on the map, as given in the drawing of the blocks to stack."""

    x_m: float
    y_m: float
    heading_deg: float = 0.0

    @property
    def pose(self) -> Pose2:
        """Pose map_T_base at which the robot starts to build the drawing."""
        return Pose2(self.x_m, self.y_m, math.radians(self.heading_deg))


class DrawnLandmark(LevelPose):
    """Square landmark in the drawing of a wall of blocks, with its pose on the map and its side in [mm]."""

    side_mm: Positive = 60.0


class DrawnRow(LevelPose):
    """Row of blocks next to each other in a plan.

    The row's pose on the map is that of a block whose position in `along_mm` is 0.
    """

    along_mm: Annotated[tuple[float, ...], Field(min_length=1)]
    """Positions of the blocks along the row's own y axis."""


class DrawnBlock(NamedTuple):
    """A block of a wall's drawing, with its position in the rows and its goal on the map."""

    row: int
    """Index of the row, from 0."""
    column: int
    """Index in the row, from 0."""
    place: BlockPlace

    @property
    def key(self) -> tuple[str | int, ...]:
        """Return the path of keys to the block's position in the drawing's YAML file."""
        return "rows", self.row, "along_mm", self.column

    @property
    def words(self) -> str:
        """Name of the block in messages, such as "block 2 of row 1"."""
        return f"block {self.column + 1} of row {self.row + 1}"


class Drawing(FileModel):
    """File with the drawing of a wall of blocks, from which a task and its building plan are made."""

    format: Literal["handcart-drawing/1"]
    start: DrawnStart
    """Start pose of the robot."""
    block_mm: tuple[Positive, Positive, Positive]
    """Length (along which the fingers close), width, height of all blocks."""
    landmarks: Annotated[dict[str, DrawnLandmark], Field(min_length=1)]
    tables: Annotated[dict[str, Table], Field(min_length=1)]
    """Tables that carry blocks; a stone at the end of a row is one, too."""
    supply: Annotated[tuple[LevelPose, ...], Field(min_length=1)]
    """Poses of the waiting blocks, on the map, in the order in which they are taken."""
    carried: Annotated[tuple[LevelPose, ...], Field(min_length=1)]
    """Seats of the blocks on the robot's own table, in the base frame."""
    rows: Annotated[tuple[DrawnRow, ...], Field(min_length=1)]
    """Rows of the wall, in any order."""

    @property
    def block(self) -> tuple[float, float, float]:
        """Length, width and height of all blocks, in [m]."""
        length, width, height = (positive / 1e3 for positive in self.block_mm)
        return length, width, height

    @property
    def blocks(self) -> list[DrawnBlock]:
        """All blocks of the wall, row by row."""
        found = []
        for row, drawn in enumerate(self.rows):
            for column, along in enumerate(drawn.along_mm):
                floor = drawn.floor.compose(Pose2(0.0, along / 1e3, 0.0))
                place = BlockPlace(
                    x_m=floor.x, y_m=floor.y, height_m=drawn.height_m, heading_deg=drawn.heading_deg
                )
                found.append(DrawnBlock(row, column, place))
        return found
