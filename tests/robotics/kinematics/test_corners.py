"""Points whose hull holds a body."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box, Cylinder, Hull, Shape, Sphere, corners
from handcart.robotics.navigation.maps.bump_area import leading_points

POSE = transform((1.0, 2.0, 3.0), (0.0, 0.0, math.pi / 2))


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        (Box(POSE, (0.2, 0.4, 0.6)), (0.2, 0.1, 0.3)),
        (Cylinder(POSE, 0.1, 0.6), (0.1, 0.1, 0.3)),
        (Sphere(POSE, 0.1), (0.1, 0.1, 0.1)),
        (Hull(POSE, np.array([[-0.1, -0.2, -0.3], [0.1, 0.2, 0.3]])), (0.2, 0.1, 0.3)),
    ],
)
def test_corners_reach_as_far_as_the_body(shape: Shape, half: tuple[float, float, float]) -> None:
    found = corners(shape)
    assert found.min(axis=0) == pytest.approx(np.array([1.0, 2.0, 3.0]) - half)
    assert found.max(axis=0) == pytest.approx(np.array([1.0, 2.0, 3.0]) + half)


@pytest.mark.parametrize("forwards", [True, False])
def test_the_leading_half_of_each_body_may_touch(forwards: bool) -> None:
    square = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]])
    found = leading_points([square, square - (0.2, 0.0)], forwards)
    wanted = {0.1, -0.1} if forwards else {-0.1, -0.3}
    assert {round(x, 6) for x in found[:, 0]} == wanted
    assert leading_points([], forwards).shape == (0, 2)
