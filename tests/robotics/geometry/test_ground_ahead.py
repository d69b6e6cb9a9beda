"""Ways and rough ground."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from handcart.robotics.geometry.ground_ahead import ground_ahead

CELL, CORNER = 0.1, np.array([-2.0, -1.5])


def rough() -> np.ndarray:
    x, y = CORNER[0] + CELL * np.arange(41), CORNER[1] + CELL * np.arange(31)
    return np.asarray(0.2 * np.sin(2.0 * x)[None, :] * np.cos(1.5 * y)[:, None])


def test_ways_end_where_sampled_points_of_them_come_under_the_ground() -> None:
    rng = np.random.default_rng(2)
    start, heights = np.array([0.3, 0.1, 0.45]), rough()
    ways = np.c_[rng.uniform(-4.0, 4.0, (300, 2)), rng.uniform(-0.9, 0.2, 300)]
    shares = ground_ahead(start, ways, CORNER, CELL, heights, float(heights.max()))
    axes = CORNER[1] + CELL * np.arange(31), CORNER[0] + CELL * np.arange(41)
    ground = RegularGridInterpolator(axes, heights, bounds_error=False, fill_value=-9.0)
    steps = np.linspace(0.0, 1.0, 4001)
    points = start + ways[:, None] * steps[:, None]
    under = points[..., 2] <= ground(points[..., 1::-1])
    first = np.where(under.any(axis=1), steps[under.argmax(axis=1)], np.inf)
    assert 50 < np.isfinite(first).sum() < 290
    np.testing.assert_allclose(shares, first, atol=2e-3)


def test_straight_down_and_beside_the_field() -> None:
    heights = rough()
    top = float(heights.max())
    down = np.array([[0.0, 0.0, -2.0]])
    (share,) = ground_ahead(np.array([0.0, 0.0, 1.0]), down, CORNER, CELL, heights, top)
    assert abs(share - 0.5) < 1e-9
    assert np.isinf(ground_ahead(np.array([9.0, 0.0, 1.0]), down, CORNER, CELL, heights, top)).all()
    up = np.array([[1.0, 0.0, 2.0]])
    assert np.isinf(ground_ahead(np.array([0.0, 0.0, 1.0]), up, CORNER, CELL, heights, top)).all()
