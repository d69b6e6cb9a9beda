"""A picture that lies on a level surface."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.numerics.arrays import ByteArray

Levels = Sequence[tuple[ByteArray, float]]
"""A grey picture (h, w) in falling resolution, each with the size of a pixel, in [m]."""


class Sheet:
    """Printed picture on a level surface, which cameras see from above and nothing collides with.

    Its frame: origin in the middle, x to the right of the picture, y up, z upwards.
    """

    def __init__(self, pose: Transform, levels: Levels) -> None:
        self.pose = pose
        """world_T_sheet (4, 4)."""
        self.levels = levels

    def face(self) -> Transform:
        """Return the picture's frame (4, 4) in the world: origin in its upper left corner, x along its rows,
        y down its columns.
        """
        picture, metres = self.levels[0]
        height, width = (size * metres for size in picture.shape)
        return np.asarray(self.pose @ transform((-width / 2, height / 2, 0.0), (math.pi, 0.0, 0.0)))
