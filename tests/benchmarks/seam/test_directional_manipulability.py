"""Directional manipulability against linear programs and difference quotients."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.seam.directional_manipulability import (
    directional,
    manipulability,
    top_speed,
    top_speed_by_program,
)
from benchmarks.seam.performance import (
    performance,
    printed_performance,
    speed_margin,
    sure_performance,
)
from benchmarks.seam.planar_arm import PlanarArm


@pytest.mark.parametrize(("m", "n"), [(2, 2), (2, 3), (3, 4), (3, 7), (5, 5), (6, 6), (6, 7), (6, 8)])
def test_top_speed_is_that_of_the_linear_program(m: int, n: int) -> None:
    rng = np.random.default_rng(10 * m + n)
    jacobians, directions = rng.normal(size=(40, m, n)), rng.normal(size=(40, m))
    velocity = rng.uniform(0.3, 3.0, n)
    exact = [top_speed_by_program(J, k, velocity) for J, k in zip(jacobians, directions, strict=True)]
    np.testing.assert_allclose(top_speed(jacobians, directions, velocity), exact, rtol=1e-7)


def test_a_square_arm_with_equal_limits_has_the_paper_like_form() -> None:
    rng = np.random.default_rng(0)
    J, k = rng.normal(size=(3, 3)), rng.normal(size=3)
    assert top_speed(J, k, np.ones(3)) == pytest.approx(1.0 / np.abs(np.linalg.inv(J) @ k).max())


def test_stretched_out_an_arm_moves_across_but_not_obliquely() -> None:
    jacobian = PlanarArm().jacobian(np.array([0.0, 0.0]))
    across, oblique = np.array([0.0, 1.0]), np.array([np.sqrt(0.5), np.sqrt(0.5)])
    assert manipulability(jacobian) == 0.0
    assert top_speed(jacobian, across, np.ones(2)) == pytest.approx(3.0)
    assert top_speed(jacobian, oblique, np.ones(2)) == pytest.approx(0.0, abs=1e-9)
    assert directional(jacobian, oblique).max() > 1.4  # eq. 4 alone calls that a good direction


def test_no_direction_is_top_speed_for_ever() -> None:
    assert top_speed_by_program(np.eye(2), np.zeros(2), np.ones(2)) == np.inf


def test_directional_is_tip_speed_and_torque_for_a_newton() -> None:
    arm, q, k = PlanarArm(0.7, 0.4), np.array([0.3, 0.9]), np.array([0.6, 0.8])
    assert directional(arm.jacobian(q), k) == pytest.approx(np.abs(arm.jacobian(q).T @ k))


def test_printed_performance_is_equation_6() -> None:
    j = np.array([0.4, 0.5, 0.8, 1.15, 1.5, 1.8, 1.9])
    expected = [0.0, 0.0, 0.3 / 0.65, 1.0, 0.3 / 0.65, 0.0, 0.0]
    assert printed_performance(j, 0.5, 1.8) == pytest.approx(np.array(expected), abs=1e-12)


def test_limits_of_each_joint_that_are_equal_give_equation_6() -> None:
    elements = np.abs(np.random.default_rng(1).normal(size=(500, 4)))
    low, high = np.full(4, 0.5), np.full(4, 1.8)
    printed = printed_performance(elements.max(axis=1), 0.5, 1.8)
    np.testing.assert_allclose(performance(elements, low, high), printed, atol=1e-12)


def test_guaranteed_performance_is_positive_only_at_full_speed() -> None:
    rng = np.random.default_rng(2)
    jacobians, k = rng.normal(size=(300, 3, 3)), np.array([1.0, 0.0, 0.0])
    velocity, speed = np.array([1.0, 1.5, 0.7]), 0.4
    fastest = top_speed(jacobians, k, velocity)
    elements = directional(jacobians, k)
    value = sure_performance(elements, speed / velocity, np.full(3, 5.0), fastest, speed)
    assert ((value > 0.0) <= (fastest > speed)).all()
    assert (performance(elements, speed / velocity, np.full(3, 5.0))[fastest < speed] > 0.0).any()
    assert speed_margin(np.array([0.0, 0.4, 0.8]), 0.4) == pytest.approx(np.array([0.0, 0.0, 0.5]))
