"""A book in its row."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, transform

from .book import SimulatedBook


class StandingBook(NamedTuple):
    """Pose of a book on a shelf, in the shelf frame S (x into the shelf, y to the left, z up)."""

    book: SimulatedBook
    lateral: float
    """y of the middle of its spine's foot, in [m]."""
    front: float
    """x of its spine, in [m]; below zero the spine stands out beyond the board's front edge."""
    tilt: float
    """Tilt of its height against the vertical, in [rad]."""
    yaw: float
    """Angle from the shelf's x axis to the book's depth, in [rad], counter-clockwise from above."""
    lean: float
    """Sideways tilt, in [rad], positive to the left."""

    @property
    def sides(self) -> tuple[float, float]:
        """y of the book's rightmost and of its leftmost point in the shelf frame S, in [m]."""
        half = self.book.thickness / 2 * math.cos(self.lean)
        over = self.book.height * math.sin(self.lean)
        return self.lateral - half + min(0.0, over), self.lateral + half + max(0.0, over)


def leaned(S_T_foot: Transform, thickness: float, angle: float) -> Transform:
    """Return the pose (4, 4) of a book that leans about the lower edge of one side, in the frame S.

    Args:
        S_T_foot: (4, 4) pose of the upright book in the shelf frame S.
        thickness: thickness of the book, in [m].
        angle: lean in [rad], positive to the left, about the lower edge of the side it leans to.
    """
    edge = math.copysign(thickness / 2, angle)
    turn = transform((0.0, edge, 0.0), (-angle, 0.0, 0.0))
    return np.asarray(S_T_foot @ turn @ transform((0.0, -edge, 0.0)))
