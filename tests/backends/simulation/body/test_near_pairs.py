"""Bounding spheres find the same near pairs as one pair after the other."""

from __future__ import annotations

import numpy as np

from handcart.backends.simulation.body.near_pairs import Boxes, near_boxes, near_spheres
from handcart.robotics.numerics.arrays import FloatArray


def random_poses(rng: np.random.Generator, count: int) -> FloatArray:
    poses = np.tile(np.eye(4), (count, 1, 1))
    for pose in poses:
        turn, _ = np.linalg.qr(rng.standard_normal((3, 3)))
        pose[:3, :3], pose[:3, 3] = turn, rng.uniform(-1.0, 1.0, 3)
    return poses


def test_body_is_near_a_present_box_that_its_sphere_reaches() -> None:
    rng = np.random.default_rng(0)
    poses, radii = random_poses(rng, 12), rng.uniform(0.1, 0.7, 12)
    placed, sizes = random_poses(rng, 20), rng.uniform(0.05, 0.8, (20, 3))
    there = rng.random(20) < 0.7
    expected = []
    for body in range(12):
        for box in range(20):
            local = placed[box, :3, :3].T @ (poses[body, :3, 3] - placed[box, :3, 3])
            nearest = np.clip(local, -sizes[box] / 2, sizes[box] / 2)
            if there[box] and np.linalg.norm(local - nearest) < radii[body]:
                expected.append([body, box])
    found = near_boxes(poses, radii, Boxes(sizes, placed), there)
    assert 10 < len(expected) < 150
    assert found.tolist() == expected


def test_spheres_meet_within_the_sum_of_their_radii() -> None:
    rng = np.random.default_rng(1)
    one, other = random_poses(rng, 6), random_poses(rng, 9)
    radii, others = rng.uniform(0.1, 0.8, 6), rng.uniform(0.1, 0.8, 9)
    away = np.linalg.norm(one[:, None, :3, 3] - other[None, :, :3, 3], axis=2)
    expected = np.argwhere(away < radii[:, None] + others)
    assert 3 < len(expected) < 54
    assert near_spheres(one, radii, other, others).tolist() == expected.tolist()


def test_nothing_is_near_nothing() -> None:
    poses, radii = random_poses(np.random.default_rng(2), 3), np.ones(3)
    none = Boxes(np.empty((0, 3)), np.empty((0, 4, 4)))
    assert near_boxes(poses, radii, none, np.empty(0, dtype=np.bool_)).shape == (0, 2)
