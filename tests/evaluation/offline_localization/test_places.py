"""Fixes at which no receiver was: (0, 0), out of range, far away, repeated."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.evaluation.offline_localization.logs.places import checked_places
from handcart.robotics.numerics.arrays import FloatArray


def drive(latitude: float = 48.0, longitude: float = 9.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Latitudes, longitudes and times of a minute's drive."""
    steps = np.random.default_rng(1).uniform(0.5e-5, 1.5e-5, (60, 2)).cumsum(axis=0)
    lons = (longitude + steps[:, 1] + 180.0) % 360.0 - 180.0
    return latitude + steps[:, 0], lons, np.arange(60.0)


@pytest.mark.parametrize(
    "middle", [(48.0, 9.0), (0.0, -60.0), (-33.9, -70.6), (48.0, 179.9998), (89.999, 9.0), (0.0, 0.0)]
)
def test_good_places_are_left_as_they_are(middle: tuple[float, float]) -> None:
    lats, lons, times = drive(*middle)
    lats[5] = lons[5] = math.nan
    kept_lats, kept_lons, notes = checked_places(lats, lons, times)
    assert notes == []
    np.testing.assert_array_equal(kept_lats, lats)
    np.testing.assert_array_equal(kept_lons, lons)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ((0.0, 0.0), "3 fixes are at (0, 0)"),
        ((-2e10, -2e10), "3 fixes lie beyond the range of degrees"),
        ((9.0, 48.0), "3 fixes lie more than 100 km from the others"),
    ],
)
@pytest.mark.parametrize("first", [0, 30])
def test_places_without_a_receiver_are_left_out(place: tuple[float, float], words: str, first: int) -> None:
    lats, lons, times = drive()
    lats[first : first + 3], lons[first : first + 3] = place
    kept, _, notes = checked_places(lats, lons, times)
    assert np.flatnonzero(np.isnan(kept)).tolist() == [first, first + 1, first + 2]
    assert len(notes) == 1
    assert notes[0].startswith(words)
    assert f"first after {first:.1f} s" in notes[0]


def test_latitudes_beyond_the_pole_are_called_exchanged() -> None:
    lats, lons, times = drive(-33.0, 151.0)
    _, _, notes = checked_places(lons, lats, times)
    assert "latitude and longitude are exchanged" in notes[0]


def test_a_receiver_that_repeats_itself_is_heard_once() -> None:
    lats, lons, times = drive()
    lats[20:30], lons[20:30] = lats[20], lons[20]
    lats[41], lons[41] = lats[40], lons[40]  # two are too few
    kept, _, notes = checked_places(lats, lons, times)
    assert np.flatnonzero(np.isnan(kept)).tolist() == list(range(21, 30))
    assert "9 fixes only repeat the one before, first after 21.0 s" in notes[0]
