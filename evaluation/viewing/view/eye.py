"""Initial camera of the page: the robot is in the middle of the part that the panel leaves visible."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

EYE_FROM_ROBOT_M = np.array([-2.5, -2.8, 3.9])
OUTDOOR_FACTOR = 1.6
ROBOT_HEIGHT_M = 0.4
# of a tall picture's height, covered by the panel at the bottom; a wide one has it at its side
PANEL_SHARE = 0.5


class Eye(NamedTuple):
    """Position and direction from which a web page shows the world."""

    position: FloatArray
    """(3,) in the world, in [m]."""
    look_at: FloatArray
    """(3,) in the world, in [m]: the point in the middle of the picture."""


def eye_on(robot: FloatArray, fov: float, aspect: float, outdoors: bool) -> Eye:
    """Return the view with which a web page shows the robot in the middle of the part of the picture that the
    page's panel leaves free.

    Args:
        robot: (3,) position of the robot's base in the world, in [m].
        fov: vertical angle of view, in [rad].
        aspect: width of the picture over its height.
        outdoors: whether to look from farther away.
    """
    middle = robot + np.array([0.0, 0.0, ROBOT_HEIGHT_M])
    position = middle + EYE_FROM_ROBOT_M * (OUTDOOR_FACTOR if outdoors else 1.0)
    ahead = middle - position
    distance = float(np.linalg.norm(ahead))
    ahead = ahead / distance
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    up = np.cross(right / np.linalg.norm(right), ahead)
    covered = PANEL_SHARE if aspect < 1.0 else 0.0
    return Eye(position, middle - covered * distance * math.tan(0.5 * fov) * up)
