"""Outlines of bases: distances to points and to other outlines."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.footprint import Footprint, polygon, polygon_gap

RECTANGLE = polygon(np.array([[0.3, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.3, -0.2]]))
L_SHAPE = polygon(np.array([[0.3, 0.3], [-0.3, 0.3], [-0.3, -0.3], [0.05, -0.3], [0.05, 0.05], [0.3, 0.05]]))


def test_distances_of_a_polygon_are_negative_inside() -> None:
    points = np.array([[0.0, 0.0], [0.4, 0.0], [0.33, 0.24], [0.29, 0.0], [-0.2, 0.1]])
    assert RECTANGLE.distances(points) == pytest.approx([-0.2, 0.1, 0.05, -0.01, 0.0])
    assert RECTANGLE.inscribed == pytest.approx(0.2)
    assert RECTANGLE.radius == pytest.approx(math.hypot(0.3, 0.2))


def test_notch_of_an_l_shape_is_outside() -> None:
    assert L_SHAPE.distances(np.array([[0.2, -0.1], [0.0, -0.2]])) == pytest.approx([0.15, -0.05])


def test_disc_measures_from_its_circle() -> None:
    disc = Footprint(0.25)
    assert disc.is_disc
    assert disc.inscribed == 0.25
    assert disc.distances(np.array([[0.3, 0.4], [0.0, 0.1]])) == pytest.approx([0.25, -0.15])


def test_turned_footprint_keeps_points_at_their_distance() -> None:
    angle, points = 0.7, np.random.default_rng(1).uniform(-0.6, 0.6, (50, 2))
    back = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    np.testing.assert_allclose(RECTANGLE.turned(angle).distances(points @ back), RECTANGLE.distances(points))


@pytest.mark.parametrize(
    ("corners", "gap"),
    [
        ([[0.5, -1.0], [0.6, -1.0], [0.6, 1.0], [0.5, 1.0]], 0.2),
        ([[0.28, -1.0], [0.6, -1.0], [0.6, 1.0], [0.28, 1.0]], -0.02),
        ([[-1.0, -0.01], [1.0, -0.01], [1.0, 0.01], [-1.0, 0.01]], -1e-6),
        ([[0.33, 0.24], [0.5, 0.24], [0.5, 0.5], [0.33, 0.5]], 0.05),
    ],
    ids=["apart", "corners inside", "a bar across", "corner to corner"],
)
def test_gap_of_two_outlines(corners: list[list[float]], gap: float) -> None:
    other = np.array(corners)
    assert polygon_gap(RECTANGLE.corners, other) == pytest.approx(gap)
    assert polygon_gap(other, RECTANGLE.corners) == pytest.approx(gap)
