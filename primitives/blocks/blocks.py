"""World model section of blocks."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.base import WheelTravel
from handcart.files.models.loading import Loaded, load_document
from handcart.files.yaml.yaml_document import read_document
from handcart.primitives.blocks.building import Building
from handcart.primitives.knowledge.section import NamedFiles, Section
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.blocks.block_finder import MIN_FACE_SIZE_M

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile
    from handcart.files.errors import Finding


class Fixed(NamedTuple):
    """Fixation: measured pose of the base at a landmark, with the state of the robot at the measurement."""

    landmark: str
    place: str
    """Name of the base's target place."""
    pose: Pose2
    """map_T_base, with the hand where it was then."""
    sigma: tuple[float, float]
    """Standard deviations of the position in [m] and the heading in [rad]."""
    reach: tuple[float, float]
    """x and y of the hand at the measurement, in the base frame, in [m]: the base tilts with it."""
    attitude: tuple[float, float, float]
    """Roll, pitch and yaw by the inertial sensors then, in [rad]."""
    travel: WheelTravel
    """Travel of the wheels at the measurement, in [m]; the pose is invalid once they roll on."""
    moved: float
    """Time over which the gyros' rates were integrated until the measurement, in [s], by `Attitude.moved`."""
    swings: int = 0
    """Number of swings of the loaded arm since the measurement, see `turn_by_model`; each turns the base a
    little.
    """

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of `pose`: x, y on the map in [m] and heading in [rad]."""
        return np.diag([self.sigma[0], self.sigma[0], self.sigma[1]]) ** 2


class Placed(NamedTuple):
    """Record of a block that the robot has put down at its goal, with the block's pose."""

    number: int
    pose: Pose2
    """Pose of the block on the map."""
    height: float
    """Height of the block's foot, in [m]."""


@dataclass
class Blocks(Section):
    """World model section for stacking blocks, with the building plan, the blocks placed so far, and the
    base's pose measured at a landmark.
    """

    FILES: ClassVar = {"building": Building}
    LEARNED: ClassVar = ("fixed", "placed", "taken")

    building: Building | None = None
    """The building plan."""
    fixed: Fixed | None = None
    """Pose of the base by the latest landmark."""
    placed: tuple[Placed, ...] = ()
    """Blocks that were put at their goals."""
    taken: tuple[int, ...] = ()
    """Numbers of the blocks that have left the supply."""
    listed: Loaded[Building] | None = field(default=None, repr=False, compare=False)
    """The building plan with the lines of its file."""

    @override
    @classmethod
    def load(cls, files: NamedFiles) -> Self:
        listed = files.read("building", lambda path: load_document(read_document(path), Building))
        return cls() if listed is None else cls(listed.value, listed=listed)

    @override
    def faults(self, robot: RobotFile) -> Iterator[Finding]:
        """Yield findings if the blocks don't fit between the fingers, or are too small for the camera."""
        if self.listed is None or robot.gripper is None:
            return
        length, width, _ = self.listed.value.block_mm
        if length >= robot.gripper.opening_mm:
            wrong = f"the blocks are {length:g} mm long, which is the side between the fingers"
            allowed = f"less than {robot.gripper.opening_mm:g} mm, as far as the fingers open"
            yield self.listed.finding(("block_mm",), f"{wrong}; allowed: {allowed}")
        if min(length, width) < 1e3 * MIN_FACE_SIZE_M:
            wrong = f"the blocks' upper sides are {length:g} x {width:g} mm, too small for the camera"
            yield self.listed.finding(
                ("block_mm",), f"{wrong}; allowed: at least {1e3 * MIN_FACE_SIZE_M:g} mm"
            )

    @override
    def names(self) -> Mapping[str, Collection[object]]:
        if self.building is None:
            return {}
        return {"landmarks": self.building.landmarks, "blocks": self.building.numbers}

    @override
    def noted(self) -> dict[str, Any]:
        return {
            "fixed": list(self.fixed) if self.fixed else None,
            "placed": [list(placed) for placed in self.placed],
            "taken": list(self.taken),
        }
