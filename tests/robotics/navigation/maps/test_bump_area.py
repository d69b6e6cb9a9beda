"""Area that is avoided after the base ran into an obstacle."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.navigation.maps.bump_area import bump_areas, bump_fronts

RADIUS = 0.34


def gap_to(areas: np.ndarray, x: float, y: float) -> float:
    return float(np.hypot(*(areas - (x, y)).T).min())


@pytest.mark.parametrize("aside", [-0.3, 0.0, 0.25])
def test_the_area_covers_a_box_wherever_it_was_touched(aside: float) -> None:
    """A box of 0.4 m, run into off its middle: no corner is further than routes keep off what was sensed."""
    ahead = math.sqrt(RADIUS**2 - aside**2)
    areas = bump_areas(np.array([[1.0, 2.0, math.pi / 2]]), RADIUS)
    low, high = (aside, aside + 0.4) if aside > 0.0 else (aside - 0.4, aside)
    for across in np.linspace(low, high, 9):
        for along in np.linspace(ahead, ahead + 0.4, 9):
            assert gap_to(areas, 1.0 - across, 2.0 + along) < 0.1 + 0.05


def test_the_area_leaves_free_where_the_footprint_was() -> None:
    areas = bump_areas(np.array([[1.0, 2.0, 0.0]]), RADIUS)
    assert gap_to(areas, 1.0, 2.0) >= RADIUS - 1e-9
    for back in np.linspace(0.0, 1.0, 20):
        assert gap_to(areas, 1.0 - back, 2.0) >= RADIUS - 1e-9


def test_fronts_lie_on_the_footprint_ahead_of_the_motion() -> None:
    fronts = bump_fronts(np.array([[1.0, 2.0, math.pi]]), RADIUS)
    assert np.hypot(*(fronts - (1.0, 2.0)).T) == pytest.approx(np.full(len(fronts), RADIUS))
    assert (fronts[:, 0] <= 1.0 - 0.5 * RADIUS + 1e-9).all()


def test_no_bump_leaves_no_points() -> None:
    nothing = np.empty((0, 3))
    assert bump_fronts(nothing, RADIUS).shape == bump_areas(nothing, RADIUS).shape == (0, 2)
