"""Turn and tilt by inertial sensors: estimates at rest, and their time constants."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.navigation.odometry.attitude import Attitude, yaw_sigma

LEVEL = np.array([0.0, 0.0, 9.81])


def turning(rate: float) -> np.ndarray:
    return np.array([7.0, 8.0, rate])  # the other two gyros do not count


def test_a_bias_is_learned_at_rest_and_taken_out_of_turns() -> None:
    attitude = Attitude()
    for _ in range(20):
        attitude.update(turning(0.03), LEVEL, 0.05, at_rest=True)
    assert (attitude.yaw, attitude.moved) == (0.0, 0.0)
    for _ in range(10):
        attitude.update(turning(0.23), LEVEL, 0.05, at_rest=False)
    assert attitude.yaw == pytest.approx(0.2 * 0.5)
    assert attitude.moved == pytest.approx(0.5)


def test_a_bias_is_the_mean_of_five_seconds() -> None:
    attitude, readings = Attitude(), [0.03 + 0.0005 * (-1) ** k for k in range(50)]
    for reading in readings:
        attitude.update(turning(reading), LEVEL, 0.1, at_rest=True)
    attitude.update(turning(0.0), LEVEL, 1.0, at_rest=False)
    assert attitude.yaw == pytest.approx(-np.mean(readings))
    attitude = Attitude()
    for _ in range(100):
        attitude.update(turning(0.03), LEVEL, 0.1, at_rest=True)
    attitude.update(turning(0.0315), LEVEL, 0.1, at_rest=True)
    attitude.update(turning(0.0), LEVEL, 1.0, at_rest=False)
    assert attitude.yaw == pytest.approx(-(0.03 + 0.0015 / 50.0))


@pytest.mark.parametrize(
    ("beside", "turned"), [(0.0019, 0.0), (-0.0019, 0.0), (0.0021, 0.0021), (-0.003, -0.003)]
)
def test_at_rest_more_than_its_bias_is_a_turn(beside: float, turned: float) -> None:
    attitude = Attitude()
    attitude.update(turning(0.03), LEVEL, 1.0, at_rest=True)
    attitude.update(turning(0.03 + beside), LEVEL, 1.0, at_rest=True)
    assert attitude.yaw == pytest.approx(turned)
    assert attitude.moved == (0.0 if turned == 0.0 else 1.0)


@pytest.mark.parametrize(("first", "turned"), [(0.99, 0.0), (-0.99, 0.0), (1.01, 1.01)])
def test_at_first_any_bias_below_one_is_learned(first: float, turned: float) -> None:
    attitude = Attitude()
    attitude.update(turning(first), LEVEL, 1.0, at_rest=True)
    assert attitude.yaw == pytest.approx(turned)


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.1, 0.0), (0.0, -0.2), (-0.15, 0.25)])
def test_tilt_is_where_gravity_is_felt(roll: float, pitch: float) -> None:
    felt = 9.81 * np.array(
        [-math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)]
    )
    attitude = Attitude()
    assert attitude.tilt == (0.0, 0.0)
    attitude.update(np.zeros(3), felt, 1.0, at_rest=False)
    assert attitude.tilt == pytest.approx((roll, pitch))


def test_gravity_is_averaged_over_half_a_second() -> None:
    attitude = Attitude()
    attitude.update(np.zeros(3), LEVEL, 1.0, at_rest=True)
    attitude.update(np.zeros(3), np.add(LEVEL, (1.0, 0.0, 0.0)), 0.05, at_rest=True)
    assert attitude.tilt == pytest.approx((0.0, math.atan2(-0.1, 9.81)))


def test_the_sigma_of_a_turn_is_of_walk_and_bias() -> None:
    assert yaw_sigma(0.01, 0.0) == 0.0
    assert yaw_sigma(0.01, 4.0) == pytest.approx(0.01 * math.sqrt(4.0 + 16.0 / 5.0))
