"""The initial camera of the page shows the robot and its surroundings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.evaluation.viewing.view.eye import ROBOT_HEIGHT_M, Eye, eye_on
from handcart.robotics.numerics.arrays import FloatArray

ROBOT = np.array([4.0, -2.0, 0.1])
FOV = math.radians(75.0)


def seen_at(point: FloatArray, eye: Eye, aspect: float) -> tuple[float, float]:
    """Return the position of a point in the picture, -1 to 1 from left to right and from bottom to top."""
    ahead = eye.look_at - eye.position
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    off = point - eye.position
    half = off @ ahead * math.tan(0.5 * FOV)
    return float(off @ right / half / aspect), float(off @ np.cross(right, ahead) / half)


@pytest.mark.parametrize(("aspect", "height"), [(1.6, 0.0), (0.5, 0.5)])
@pytest.mark.parametrize("outdoors", [False, True])
def test_robot_is_in_the_middle_of_what_is_visible(aspect: float, height: float, outdoors: bool) -> None:
    eye = eye_on(ROBOT, FOV, aspect, outdoors)
    middle = ROBOT + np.array([0.0, 0.0, ROBOT_HEIGHT_M])
    assert seen_at(middle, eye, aspect) == pytest.approx((0.0, height), abs=0.15)
