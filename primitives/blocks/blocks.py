"""What is known of blocks."""

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
    """Where the base stands, by a landmark."""

    landmark: str
    place: str
    """At which place of the map the base should stand."""
    pose: Pose2
    """map_T_base, with the hand where it was then."""
    sigma: tuple[float, float]
    """Of its position in [m] and its heading in [rad]."""
    reach: tuple[float, float]
    """Where the hand was, in the base frame, in [m]: the base leans after it."""
    attitude: tuple[float, float, float]
    """Roll, pitch and yaw by the inertial sensors then, in [rad]."""
    travel: tuple[float, float]
    """What the wheels had rolled then, in [m]: once they roll on, this pose is over."""
    moved: float
    """Over how long the gyros' rates had been added up then, in [s]: by `Attitude.moved`."""
    swings: int = 0
    """Of the loaded arm since then."""

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
    """Of its foot, in [m]."""


@dataclass
class Blocks(Section):
    """Of a robot that stacks them."""

    FILES: ClassVar = {"building": Building}
    LEARNED: ClassVar = ("fixed", "placed", "taken")

    building: Building | None = None
    """The building plan."""
    fixed: Fixed | None = None
    """Where the base stands by the landmark that was seen last."""
    placed: tuple[Placed, ...] = ()
    """The blocks that stand where they go."""
    taken: tuple[int, ...] = ()
    """The blocks that don't wait any more."""

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
