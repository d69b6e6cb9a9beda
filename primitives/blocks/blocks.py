"""World model section of blocks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from handcart.primitives.blocks.building import Building
from handcart.primitives.knowledge.section import Section
from handcart.robotics.geometry.pose2 import Pose2


class Fixed(NamedTuple):
    """Pose of the base, measured at a landmark."""

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
    travel: tuple[float, float]
    """Travel of the wheels at the measurement, in [m]; the pose is invalid once they roll on."""
    moved: float
    """Over how long the gyros' rates had been added up then, in [s]: by `Attitude.moved`."""
    swings: int = 0
    """Swings of the loaded arm since the measurement."""

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) of `pose`, of x, y in [m] and heading in [rad]."""
        return np.diag([self.sigma[0], self.sigma[0], self.sigma[1]]) ** 2


class Placed(NamedTuple):
    """A block that was put where it goes."""

    number: int
    pose: Pose2
    """On the map."""
    height: float
    """Height of its foot, in [m]."""


@dataclass
class Blocks(Section):
    """Knowledge of a robot that stacks blocks."""

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

    @override
    def names(self) -> Mapping[str, Collection[object]]:
        if self.building is None:
            return {}
        return {"landmarks": self.building.landmarks, "blocks": self.building.numbers}

    @override
    def noted(self) -> dict[str, Any]:
        return {
            "fixed": list(self.fixed) if self.fixed else None,
            "placed": [list(each) for each in self.placed],
            "taken": list(self.taken),
        }
