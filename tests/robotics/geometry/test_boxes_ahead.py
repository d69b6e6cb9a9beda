"""Ways and boxes."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.boxes_ahead import boxes_ahead


def test_ways_end_where_sampled_points_of_them_enter_a_box() -> None:
    rng = np.random.default_rng(4)
    start, ways = np.zeros(3), rng.uniform(-3.0, 3.0, (300, 3))
    middles, halves = rng.choice([-1.0, 1.0], (7, 3)) * rng.uniform(0.8, 2.0, (7, 3)), np.full((7, 3), 0.5)
    turns = Rotation.random(7, rng).as_matrix()
    shares = boxes_ahead(start, ways, middles, turns, halves)
    steps = np.linspace(0.0, 1.0, 4001)
    points = ways[:, None] * steps[:, None]
    inside = np.zeros(points.shape[:2], bool)
    for middle, turn, half in zip(middles, turns, halves, strict=True):
        inside |= (np.abs((points - middle) @ turn) <= half).all(axis=2)
    first = np.where(inside.any(axis=1), steps[inside.argmax(axis=1)], np.inf)
    assert 20 < np.isfinite(first).sum() < 280
    np.testing.assert_allclose(shares, first, atol=1e-3)


def test_from_inside_a_box_is_met_where_the_way_leaves_it() -> None:
    ways = np.array([[4.0, 0.0, 0.0], [0.0, -4.0, 0.0], [0.5, 0.0, 0.0]])
    shares = boxes_ahead(np.zeros(3), ways, np.zeros((1, 3)), np.eye(3)[None], np.array([[1.0, 2.0, 3.0]]))
    assert shares.tolist() == [0.25, 0.5, np.inf]
