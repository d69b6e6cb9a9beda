"""Arcs and lines that are fitted to the path of a handle."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.manipulation.doors.path_fit import PathFit, PathPrior, fit_path
from handcart.robotics.numerics.arrays import FloatArray

SIGMA_M = 2e-4
PRIOR = PathPrior(0.0, 0.2, 0.0, 2.0, 0.03)


def arc(
    radius: float, degrees: float, left: bool = True, heading: float = 0.0, count: int = 120
) -> FloatArray:
    """Points (n, 3) of an arc that begins at (1, 2, 0.9) with a heading in [rad]."""
    turns = np.radians(degrees) * np.linspace(0.0, 1.0, count)
    side = 1.0 if left else -1.0
    flat = np.column_stack([radius * np.sin(turns), side * radius * (1.0 - np.cos(turns))])
    cos, sin = math.cos(heading), math.sin(heading)
    turned = flat @ np.array([[cos, sin], [-sin, cos]])
    return np.asarray(np.column_stack([turned, np.zeros(count)]) + np.array([1.0, 2.0, 0.9]))


def noisy(points: FloatArray, seed: int) -> FloatArray:
    return points + SIGMA_M * np.random.default_rng(seed).standard_normal(points.shape)


@pytest.mark.parametrize("left", [True, False])
def test_fit_of_an_exact_arc_gives_its_hinge(left: bool) -> None:
    fit = fit_path(arc(0.8, 20.0, left, heading=0.15), SIGMA_M, PRIOR._replace(heading=0.1))
    hinge, side = fit.hinge(), 1.0 if left else -1.0
    middle = np.array([1.0 - side * 0.8 * math.sin(0.15), 2.0 + side * 0.8 * math.cos(0.15), 0.9])
    assert fit.is_curved
    np.testing.assert_allclose(hinge.point, middle, atol=1e-3)
    assert hinge.radius == pytest.approx(0.8, abs=1e-3)
    assert math.degrees(fit.turned(arc(0.8, 20.0, left, heading=0.15)[-1])) == pytest.approx(
        side * 20.0, abs=0.03
    )


def test_fit_of_a_line_believed_an_arc_is_straight() -> None:
    line = np.column_stack([np.linspace(0.0, 0.3, 100), np.zeros(100), np.zeros(100)])
    fit = fit_path(noisy(line, 1), SIGMA_M, PRIOR._replace(curvature=1.5))
    assert fit.is_curved is False
    assert fit.travel(line[-1]) == pytest.approx(0.3, abs=2e-3)
    assert abs(math.degrees(math.atan2(*fit.tangent(line[-1])[1::-1]))) < 1.0


def test_fit_of_a_few_centimetres_leaves_the_shape_open() -> None:
    assert fit_path(noisy(arc(1.0, 1.5, count=14), 2), SIGMA_M, PRIOR).is_curved is None


def test_fit_turns_back_along_a_door_that_closes() -> None:
    path = arc(0.7, 25.0)[::-1]
    heading = math.radians(25.0) + math.pi
    fit = fit_path(path, SIGMA_M, PRIOR._replace(heading=heading))
    assert fit.curvature == pytest.approx(-1 / 0.7, rel=5e-3)
    np.testing.assert_allclose(fit.tangent(path[-1])[:2], (-1.0, 0.0), atol=3e-3)


def test_hinge_covariance_agrees_with_the_errors() -> None:
    errors = [_squared_error(seed) for seed in range(120)]
    assert 1.5 < float(np.mean(errors)) < 2.6  # two degrees of freedom


def _squared_error(seed: int) -> float:
    rng = np.random.default_rng((seed, 7))
    radius = float(rng.uniform(0.6, 1.1))
    prior = PathPrior(0.2 * float(rng.standard_normal()), 0.2, 0.0, 2.0, 0.03)
    fit: PathFit = fit_path(noisy(arc(radius, 20.0), seed), SIGMA_M, prior)
    hinge = fit.hinge()
    off = hinge.point[:2] - (1.0, 2.0 + radius)
    return float(off @ np.linalg.solve(hinge.covariance, off))
