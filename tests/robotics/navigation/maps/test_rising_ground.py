"""Ground that a level scan meets is distinguished from things."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.transform import transform
from handcart.robotics.navigation.maps.rising_ground import MAX_GROUND_SLOPE, may_be_ground

HEIGHT = 0.32


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.05, 0.0), (0.0, 0.06), (-0.04, -0.05)])
def test_where_beams_meet_a_slope_that_rises_from_the_base(tilt: tuple[float, float]) -> None:
    """All of them on a slope a little less steep than what ground may be; none on a steeper one."""
    turned = np.linspace(-math.pi, math.pi, 180, endpoint=False)
    ways = np.c_[np.cos(turned), np.sin(turned)]
    turn = transform(rpy=(*tilt, 0.0))[:3, :3]
    for share, ground in ((0.95, True), (1.1, False)):
        sinks = turn[2, :2] @ ways.T
        far = HEIGHT / np.maximum(share * MAX_GROUND_SLOPE - sinks, 1e-3)
        met = far < 8.0
        assert met.sum() > 50
        points = (far[:, None] * ways)[met]
        assert (may_be_ground(points, HEIGHT, tilt) == ground).mean() > 0.97


def test_what_stands_near_is_no_ground_even_on_a_base_that_noses_down() -> None:
    near = np.array([[1.2, 0.0], [0.9, 0.5]])
    assert not may_be_ground(near, HEIGHT, (0.0, 0.1)).any()
    assert may_be_ground(near * 3.0, HEIGHT, (0.0, 0.1)).all()
    assert may_be_ground(np.empty((0, 2)), HEIGHT, (0.0, 0.0)).shape == (0,)
