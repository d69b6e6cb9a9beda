"""A book, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from robotics.geometry.transform import Transform
from robotics.kinematics.shapes import Box

from .world_file import BookSpec


class Rest(Enum):
    """What carries a book."""

    SHELF = "shelf"
    TRAY = "tray"
    HAND = "hand"
    FLOOR = "floor"
    """Fallen: lost to the robot."""


@dataclass(eq=False, repr=False)
class Book:
    """A book and where it truly is.

    Its frame: origin at the foot of the spine, in its middle; x from the spine to the fore-edge, y to the
    left for who faces the spine, z up.
    """

    spec: BookSpec
    pose: Transform
    """world_T_book (4, 4)."""
    rest: Rest
    shelf: str | None = None
    """Name of the shelf that it stands on."""

    def __post_init__(self) -> None:
        self.thickness = self.spec.thickness_mm / 1e3
        self.height = self.spec.height_mm / 1e3
        self.depth = self.spec.depth_mm / 1e3

    @property
    def accession(self) -> int:
        """The number in its tag."""
        return self.spec.accession

    @property
    def size(self) -> tuple[float, float, float]:
        """Depth, thickness, height along x, y, z of its frame, in [m]."""
        return self.depth, self.thickness, self.height

    def box(self) -> Box:
        """The solid, posed in the world."""
        return Box(self.pose @ self.book_T_middle, self.size, f"book {self.accession}")

    @property
    def book_T_middle(self) -> Transform:
        """Of its middle (4, 4)."""
        result = np.eye(4)
        result[0, 3], result[2, 3] = self.depth / 2, self.height / 2
        return result

    def tilt(self) -> float:
        """Angle between its height and the vertical, in [rad]."""
        return float(np.arccos(np.clip(self.pose[2, 2], -1.0, 1.0)))
