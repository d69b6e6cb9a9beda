"""Position of a label on the front of a shelf."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


class LabelBox(NamedTuple):
    """Rectangle of a label on the plane x = 0 of the shelf frame.

    `centre` is its middle (y, z) in [m], and `along` the unit vector (y, z) towards the foot of the label.
    `length` is measured along the spine of the book, `width` across it, both in [m]. `paper` is True if the
    border of the label was seen, False if only print on bright ground was seen.
    """

    centre: tuple[float, float]
    along: tuple[float, float]
    length: float
    width: float
    paper: bool = True

    @property
    def lean(self) -> float:
        """Turn of the label's top to the left, as seen from the front, in [rad]; 0 if upright."""
        return math.atan2(-self.along[0], -self.along[1])

    @property
    def corners(self) -> FloatArray:
        """Corners (4, 2) of the label, y and z in the shelf frame, in [m].

        They are in the order upper left, upper right, lower right, lower left, as seen from the front.
        """
        down = np.array(self.along) * self.length / 2
        right = np.array([self.along[1], -self.along[0]]) * self.width / 2
        corners: FloatArray = (
            np.stack([-down - right, right - down, down + right, down - right]) + self.centre
        )
        return corners
