"""Motions of a standing base by millimetres."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.scans.small_motion import drift, small_motions
from handcart.robotics.numerics.arrays import FloatArray

ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)


def ranges_in_room(x: float, y: float, heading: float) -> FloatArray:
    """Ranges (n,) in a room from -2 to 3 m and from -1.5 to 2.5 m."""
    cos, sin = np.cos(ANGLES + heading), np.sin(ANGLES + heading)
    with np.errstate(divide="ignore"):
        walls = [np.where(cos > 0, (3.0 - x) / cos, (-2.0 - x) / cos)]
        walls.append(np.where(sin > 0, (2.5 - y) / sin, (-1.5 - y) / sin))
    return np.asarray(np.minimum(*walls))


def test_small_motion_of_exact_ranges_is_found() -> None:
    found = small_motions(ANGLES, ranges_in_room(0, 0, 0), ranges_in_room(0.001, -0.002, 0.002)[None])
    assert found is not None
    np.testing.assert_allclose(found[0], (0.001, -0.002, 0.002), atol=5e-5)


def test_drift_is_found_among_noise_within_a_fifth_of_a_millimetre() -> None:
    rng, times = np.random.default_rng(1), np.linspace(0.05, 8.0, 160)
    truth = np.outer(times / 8.0, (0.0005, -0.0004, -0.002))
    scans = np.array([ranges_in_room(*item) for item in truth]) + 0.01 * rng.standard_normal((160, 360))
    reference = ranges_in_room(0, 0, 0) + 0.002 * rng.standard_normal(360)
    motions = small_motions(ANGLES, reference, scans)
    assert motions is not None
    off = drift(times, motions, 25)[-1] - truth[-1]
    assert np.hypot(*off[:2]) < 6e-4
    assert abs(off[2]) < 2e-4


def test_noise_of_the_reference_is_no_drift() -> None:
    rng, times = np.random.default_rng(2), np.linspace(0.05, 30.0, 600)
    motions = np.array((0.0003, -0.0003, 0.0001)) + 0.0003 * rng.standard_normal((600, 3))
    assert np.abs(drift(times, motions, 20)).max() < 1.5e-4


def test_bare_surroundings_give_no_motion() -> None:
    nothing = np.full(360, np.inf)
    assert small_motions(ANGLES, nothing, nothing[None]) is None
