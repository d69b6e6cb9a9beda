"""Tests of the tilt that accelerometers measure beyond the suspension's model."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.base_lean import felt_beside, unmodelled_leans
from handcart.robotics.numerics.arrays import FloatArray

from .stacking import at_the_wall

SIGMA = 0.005 / 9.81 / math.sqrt(20)  # of a tilt, by the robot's file, over a second


def leans(pose: FloatArray) -> tuple[float, float]:
    return math.atan2(pose[2, 1], pose[2, 2]), -math.asin(pose[2, 0])


def felt(robot: Robot) -> tuple[Any, int]:
    """Return the measured tilt, and the number of periods it took."""
    periods, count = felt_beside(robot), 0
    while True:
        try:
            next(periods)
        except StopIteration as end:
            return end.value, count
        robot.step()
        count += 1


def test_what_is_felt_far_beside_the_model_is_taken_half_each_time() -> None:
    """A tilt measured both times, for example by a mounting error of the sensors, does not count."""
    with at_the_wall() as rig:
        then = np.array([0.03, -0.02])
        one, other = unmodelled_leans(rig.robot, then, then + np.array([2e-3, -4e-3]))
        assert leans(other) == pytest.approx((1e-3, -2e-3), rel=0.01)
        assert leans(one) == pytest.approx((-1e-3, 2e-3), rel=0.01)


def test_of_noise_hardly_any_is_left() -> None:
    rng = np.random.default_rng(0)
    drawn = SIGMA * rng.standard_normal((500, 2, 2))
    with at_the_wall() as rig:
        left = np.array([leans(unmodelled_leans(rig.robot, *item)[1]) for item in drawn])
    shares = np.sqrt((left**2).mean() / (((drawn[:, 1] - drawn[:, 0]) / 2) ** 2).mean())
    assert shares < 0.7


def test_it_leans_about_the_pivot() -> None:
    with at_the_wall() as rig:
        pivot = rig.robot.spec.suspension.model.pivot
        for moved in unmodelled_leans(rig.robot, np.zeros(2), np.array([0.02, 0.01])):
            assert (moved @ (0.0, 0.0, pivot, 1.0))[:3] == pytest.approx((0.0, 0.0, pivot))
            assert np.linalg.norm((moved @ (0.0, 0.0, pivot + 1.0, 1.0))[:2]) > 0.005


def test_tilt_is_averaged_over_a_second_beside_the_model() -> None:
    """The arm is off the middle: the base tilts as its model predicts."""
    with at_the_wall() as rig:
        found = [felt(rig.robot) for _ in range(8)]
        assert {count for _, count in found} == {round(1.0 / rig.robot.period)}
        tilts = np.array([tilt for tilt, _ in found])
        assert np.std(tilts, axis=0).max() < 2.0 * SIGMA
        assert np.abs(tilts.mean(axis=0)).max() < 0.5e-3
