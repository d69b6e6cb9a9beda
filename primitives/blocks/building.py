"""Building plan of a robot that stacks blocks: supply, goals, landmarks and tables."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from handcart.backends.description.things.board_layout import BoardLayout
from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.knowledge.place_name import Names
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

Positive = Annotated[float, Field(gt=0.0)]
LandmarkName = Annotated[str, Field(min_length=1), Names("landmarks")]
"""The name of a landmark of the building plan."""
BlockNumber = Annotated[int, Field(ge=1), Names("blocks")]
"""The number of a block of the building plan, from 1."""


class LandmarkPlan(LevelPose):
    """Landmark of the building plan, with its pose on the map."""

    side_mm: Positive = 60.0
    place: str
    """Place of the base from which the landmark is viewed."""


class BlockPlace(LevelPose):
    """Level pose on the map at which a block is to be placed."""

    landmark: str | None = None
    """Name of a landmark next to the goal, if any."""


class BoardPlan(LevelPose, BoardLayout):
    """Calibration board with its layout, and its pose on the map, known to within a few centimetres."""

    square_mm: Positive = 20.0


class Table(LevelPose):
    """Table in a building plan, posed on the map; its height is that of its top."""

    size_m: tuple[Positive, Positive]
    thickness_m: Positive = 0.04

    @property
    def box(self) -> Box:
        """Tabletop, as a box with its pose on the map."""
        return Box(self.pose @ transform((0.0, 0.0, -self.thickness_m / 2)), (*self.size_m, self.thickness_m))


class Building(FileModel):
    """File with a building plan, with the blocks that a robot stacks, their goal poses, tables and
    landmarks.
    """

    format: Literal["handcart-building/1"]
    block_mm: tuple[Positive, Positive, Positive]
    """Length (along which the fingers close), width, height of all blocks."""
    landmarks: Annotated[dict[str, LandmarkPlan], Field(default_factory=dict)]
    tables: dict[str, Table]
    boards: Annotated[dict[str, BoardPlan], Field(default_factory=dict)]
    """Boards by name, to calibrate the camera with."""
    supply: tuple[LevelPose, ...] = ()
    """Poses of the waiting blocks, on the map; the first one is block 1."""
    carried: tuple[LevelPose, ...] = ()
    """Seats of the blocks on the robot's own table, in the base frame, reused in the same order."""
    goals: tuple[BlockPlace, ...] = ()
    """Goals of the blocks, on the map."""

    @property
    def block(self) -> tuple[float, float, float]:
        """Length, width and height of all blocks, in [m]."""
        length, width, height = (positive / 1e3 for positive in self.block_mm)
        return length, width, height

    @property
    def numbers(self) -> range:
        """Return the numbers of all blocks of the plan, counted from 1."""
        return range(1, max(len(self.supply), len(self.carried), len(self.goals)) + 1)

    def seat(self, number: int) -> LevelPose:
        """Return the pose in the base frame at which the robot's own table carries block `number`, from 1."""
        return self.carried[(number - 1) % len(self.carried)]


def name_of_block(number: int) -> str:
    """Return the name of the block with a number, from 1, in the simulated world and in sensor readings."""
    return f"block {number}"
