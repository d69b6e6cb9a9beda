"""Something solid that a hand can carry."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from typing import ClassVar, Literal

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Box, Cylinder
from handcart.robotics.numerics.arrays import ByteArray

from .material import PALE_WOOD, Material

GreyImage = ByteArray
"""A grey picture (h, w), from 0 (black) to 255 (white)."""
Side = Literal["-x", "+x", "-y", "+y", "-z", "+z"]


class Rest(Enum):
    """Kind of body that supports a thing, such as the robot's tray, the robot's hand or a table."""

    TRAY = "tray"
    HAND = "hand"
    TABLE = "table"
    """Furniture of the world, or a thing on it."""
    FLOOR = "floor"
    """Fallen: lost to the robot."""
    PERSON = "person"
    """Taken away by a person: nothing collides with it, and no camera sees it."""


@dataclass(eq=False, repr=False)
class Thing(ABC):
    """Solid that a hand can carry, with its true pose: a box, or a cylinder if `is_round`.

    The origin of its frame is in its bottom face; z points up.

    Subclasses are dataclasses. Checkpoints keep those fields that `__init__` takes.
    """

    DENSITY: ClassVar[float] = 600.0
    """Density of wood, in [kg/m³]."""
    WEIGHS: ClassVar[bool] = False
    """True if the hand's force reading includes the weight of a held thing."""
    FREE: ClassVar[bool] = True
    """False if it is fixed to a joint of the world: closing fingers don't push it, and a hand that holds it
    feels what moves it."""

    pose: Transform
    """world_T_thing (4, 4)."""
    rest: Rest
    base_T_thing: Transform = field(default_factory=lambda: np.eye(4), kw_only=True)
    """Pose base_T_thing (4, 4), valid while the thing lies on the robot."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the thing, unique in the world, by which contacts refer to it."""

    @property
    @abstractmethod
    def size(self) -> tuple[float, float, float]:
        """Length, width and height along x, y and z of the thing's frame, in [m]."""

    @property
    def is_round(self) -> bool:
        """True for a cylinder along z, whose `size` is that of the box around it."""
        return False

    @property
    def carrier(self) -> str:
        """Support of the thing: "hand", "tray", "table", "floor" or "person"; a subclass may name its own
        support.
        """
        return self.rest.value

    @property
    def thing_T_middle(self) -> Transform:
        """Pose (4, 4) of the thing's middle in the thing's frame, by default right above the origin."""
        return middle_frame(0.0, self.size[2] / 2)

    @property
    def mass(self) -> float:
        """Mass of the thing, in [kg] (default: its volume times `DENSITY`)."""
        length, width, height = self.size
        return self.DENSITY * (length * width * height)

    @property
    def grey(self) -> int:
        """Grey of the thing's sides under full light, 0 to 255."""
        return 150

    @property
    def material(self) -> Material:
        """Material of the thing's unprinted sides, in colour pictures for people."""
        return PALE_WOOD

    def faces(self) -> Mapping[Side, ByteArray]:
        """Return the grey pictures (h, w) printed on the thing's sides; sides without a picture are plain.

        Each picture fills its side, as seen from outside with z up; "+z" is seen from above and "-z" from
        below, x to the right. This method is called for each image that is taken: the pictures may change,
        but the set of printed sides must not.
        """
        return {}

    def box(self) -> Box:
        """Return the thing as a box posed in the world; for a cylinder, the box around it."""
        return Box(self.pose @ self.thing_T_middle, self.size, self.name)

    def solid(self, less: float = 0.0) -> Box | Cylinder:
        """Return the thing as a box or cylinder posed in the world.

        Args:
            less: length by which the solid is made smaller along each of its axes, in [m].
        """
        pose, (x, y, z) = self.pose @ self.thing_T_middle, (side - less for side in self.size)
        return Cylinder(pose, x / 2, z, self.name) if self.is_round else Box(pose, (x, y, z), self.name)

    def tilt(self) -> float:
        """Angle between the thing's z axis and the vertical, in [rad], 0 to pi."""
        return float(np.arccos(np.clip(self.pose[2, 2], -1.0, 1.0)))


@lru_cache(maxsize=256)
def middle_frame(ahead: float, above: float) -> Transform:
    """Return the pose (4, 4) of a thing's middle in the thing's frame; it is read-only, without rotation.

    Its translation is x = `ahead`, y = 0, z = `above`, in [m].
    """
    pose = np.eye(4)
    pose[0, 3], pose[2, 3] = ahead, above
    pose.flags.writeable = False
    return pose
