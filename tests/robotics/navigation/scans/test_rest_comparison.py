"""Detection that a base at rest among people was moved, by the ranges of the same beams."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.simulation.sensors.disc_ranges import cast_at_discs
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.world.solids import FloorPlan, of_furniture
from handcart.backends.simulation.world.world_file import Furniture
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.rest_comparison import share_moved
from handcart.robotics.numerics.arrays import FloatArray

ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)
SENSOR, SIGMA_M = Pose2(0.1, 0.0, 0.0), 0.01
WALLS = [(3.0, 0.0, 6.1, 0.1), (3.0, 4.0, 6.1, 0.1), (0.0, 2.0, 0.1, 4.1), (6.0, 2.0, 0.1, 4.1)]
PLAN = FloorPlan(
    [
        of_furniture(Furniture(name="wall", x_m=x, y_m=y, size_m=(length, width, 1.0)))
        for x, y, length, width in WALLS
    ],
    0.3,
    0.3,
)
STOOD = Pose2(1.5, 1.2, 0.4)


def ends(base: Pose2, people: FloatArray, seed: int) -> FloatArray:
    """Return the ends of all beams in the base frame, in [m]."""
    sensor = base.compose(SENSOR)
    ranges = np.minimum(
        cast_rays(PLAN, sensor, ANGLES, 0.0, 12.0), cast_at_discs(people, sensor, ANGLES, 12.0)
    )
    ranges += SIGMA_M * np.random.default_rng(seed).standard_normal(len(ranges))
    rays = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    return SENSOR.apply(ranges[:, None] * rays)


@pytest.mark.parametrize("rolled", [Pose2(0.0, 0.0, 0.0), Pose2(0.003, 0.0, 0.014)])
@pytest.mark.parametrize("moved", [Pose2(0.012, 0.0, 0.0), Pose2(0.0, -0.01, 0.0), Pose2(0.005, 0.0, 0.012)])
def test_share_moved_tells_rest_from_a_small_motion(moved: Pose2, rolled: Pose2) -> None:
    before, after = np.array([[2.6, 1.4, 0.3], [1.5, 2.4, 0.3]]), np.array([[2.2, 2.2, 0.3], [0.6, 0.8, 0.2]])
    then, sensor = ends(STOOD, before, 1), np.array(SENSOR[:2])
    there = STOOD.compose(rolled)
    still = share_moved(then, ends(there, after, 2), sensor, rolled, moved, SIGMA_M)
    pushed = share_moved(then, ends(there.compose(moved), after, 3), sensor, rolled, moved, SIGMA_M)
    assert still is not None
    assert pushed is not None
    assert abs(still) < 0.4
    assert abs(pushed - 1.0) < 0.4


def test_share_moved_is_unknown_where_few_beams_tell() -> None:
    around = np.array([[1.5 + np.cos(a), 1.2 + np.sin(a), 0.3] for a in np.linspace(0.0, 6.0, 12)])
    then, now = ends(STOOD, around, 1), ends(STOOD, np.empty((0, 3)), 2)
    still, moved = Pose2(0.0, 0.0, 0.0), Pose2(0.002, 0.0, 0.0)
    assert share_moved(then, now, np.array(SENSOR[:2]), still, moved, SIGMA_M) is None
