"""Two collision libraries agree: the one that judges, and the one that plans."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from handcart.backends.simulation.body.rigid_body import fcl_body, touch
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.coal_bodies import coal_body
from handcart.robotics.kinematics.shapes import Box, Cylinder, Hull, Shape, Sphere
from handcart.robotics.numerics.arrays import FloatArray

HERE = np.eye(4)
UNSURE = 1e-6  # [m]: nearer to touching, and rounding decides


def random_pose(rng: np.random.Generator) -> Transform:
    turn, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn * np.sign(np.linalg.det(turn)), rng.uniform(-0.4, 0.4, 3)
    return pose


def random_shape(rng: np.random.Generator) -> Shape:
    a, b, c = rng.uniform(0.02, 0.5, 3).tolist()
    corners: FloatArray = rng.uniform(-0.5 * c, 0.5 * c, (12, 3))
    shapes: tuple[Shape, ...] = (
        Box(HERE, (a, b, c)),
        Cylinder(HERE, a / 2, b),
        Sphere(HERE, a / 2),
        Hull(HERE, corners),
    )
    return shapes[rng.integers(len(shapes))]


def distance(one: Shape, pose: Transform, other: Shape, other_pose: Transform) -> float:
    """Return the distance by coal, in [m]; negative for an overlap."""
    request, result = pin.coal.DistanceRequest(), pin.coal.DistanceResult()
    places = (pin.coal.Transform3s(item[:3, :3], item[:3, 3]) for item in (pose, other_pose))
    here, there = places
    return float(pin.coal.distance(coal_body(one), here, coal_body(other), there, request, result))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(index, marks=pytest.mark.slow) for index in range(1, 3))])
def test_both_say_of_1000_random_pairs_whether_they_touch(seed: int) -> None:
    rng, pairs = np.random.default_rng(seed), []
    for _ in range(1000):
        one, other = random_shape(rng), random_shape(rng)
        pose, other_pose = random_pose(rng), random_pose(rng)
        apart = distance(one, pose, other, other_pose)
        if abs(apart) > UNSURE:
            pairs.append((touch(fcl_body(one), pose, fcl_body(other), other_pose), apart < 0.0))
    assert len(pairs) > 990
    assert [pair for pair in pairs if pair[0] is not pair[1]] == []
    assert 100 < sum(touches for touches, _ in pairs) < 900
