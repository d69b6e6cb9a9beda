"""Walks of passers along waypoints."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.simulation.passers.passer_spec import PasserSpec
from handcart.backends.simulation.passers.walk import Walk


def walk(offset: float = 0.0, **keys: object) -> Walk:
    spec = {"name": "anna", "waypoints_m": ((0, 0), (4, 0), (4, 3)), "speed_m_s": 1.0, **keys}
    return Walk(PasserSpec.model_validate(spec), offset)


def test_walk_with_pauses_stands_at_its_waypoints() -> None:
    found = walk(pauses_s=(1, 2, 0), at_end="stay")
    assert found.at(0.5).position.tolist() == [0.0, 0.0]
    assert found.at(0.5).speed == 0.0
    assert found.at(3.0).position == pytest.approx([2.0, 0.0])
    assert found.at(6.0).position == pytest.approx([4.0, 0.0])
    assert found.at(9.0).position == pytest.approx([4.0, 2.0])
    assert found.at(500.0).position == pytest.approx([4.0, 3.0])
    assert found.at(500.0).speed == 0.0


@pytest.mark.parametrize(("at_end", "after_8_s"), [("turn_back", (4.0, 2.0)), ("loop", (3.2, 2.4))])
def test_walk_at_its_end_goes_on_as_stated(at_end: str, after_8_s: tuple[float, float]) -> None:
    found = walk(at_end=at_end)
    assert found.at(8.0).position == pytest.approx(after_8_s)
    lap = {"turn_back": 14.0, "loop": 12.0}[at_end]
    assert found.at(8.0 + 3 * lap).position == pytest.approx(after_8_s)
    assert found.at(8.0 + 3 * lap).walked == pytest.approx(8.0 + 3 * lap)


@pytest.mark.parametrize("at_end", ["turn_back", "loop"])
def test_companion_never_jumps_and_keeps_its_distance(at_end: str) -> None:
    leader, beside = walk(at_end=at_end), walk(0.6, at_end=at_end)
    times = np.arange(0.0, 30.0, 0.05)
    points = np.array([beside.at(time).position for time in times])
    assert np.hypot(*np.diff(points, axis=0).T).max() < 0.1  # [m] in 0.05 s
    apart = [math.dist(leader.at(time).position, beside.at(time).position) for time in times]
    assert min(apart) > 0.4
    assert max(apart) < 0.6 * 3.0
