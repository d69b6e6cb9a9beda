"""Something solid that a hand can carry."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Box


class Rest(Enum):
    """What carries a thing."""

    SHELF = "shelf"
    TRAY = "tray"
    HAND = "hand"
    TABLE = "table"
    """A table of the world, or what stands on it."""
    FLOOR = "floor"
    """Fallen: lost to the robot."""


@dataclass(eq=False, repr=False)
class Thing:
    """A box and where it truly is. Its frame: origin in the foot, z up."""

    pose: Transform
    """world_T_thing (4, 4)."""
    rest: Rest

    @property
    def name(self) -> str:
        """How contacts call it."""
        raise NotImplementedError

    @property
    def size(self) -> tuple[float, float, float]:
        """Along x, y, z of its frame, in [m]."""
        raise NotImplementedError

    @property
    def thing_T_middle(self) -> Transform:
        """Of its middle (4, 4)."""
        raise NotImplementedError

    def box(self) -> Box:
        """The solid, posed in the world."""
        return Box(self.pose @ self.thing_T_middle, self.size, self.name)

    def tilt(self) -> float:
        """Angle between its height and the vertical, in [rad]."""
        return float(np.arccos(np.clip(self.pose[2, 2], -1.0, 1.0)))
