"""MOVE_TO where walls lie on borders of the map's cells and are seen from one side; ground truth judges."""

from __future__ import annotations

import pytest

from benchmarks.driving.cell_borders import Case, drive

EXACT = Case(seed=0, offsets=(0.0, 0.0), thickness_m=0.1, is_drawn=False, tolerance_mm=40.0)


@pytest.mark.slow
def test_walls_on_cell_borders_end_in_no_false_outcome() -> None:
    arrivals = drive(EXACT, places=2)
    assert not any(arrival.false for arrival in arrivals)
    assert max(arrival.pose_off_mm for arrival in arrivals) < 40.0
    assert max(arrival.pose_sigmas for arrival in arrivals) < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [0.01, 0.05, 0.2])
@pytest.mark.parametrize("is_drawn", [False, True])
def test_a_place_that_needs_less_is_reached(thickness: float, is_drawn: bool) -> None:
    case = EXACT._replace(seed=1, thickness_m=thickness, is_drawn=is_drawn, tolerance_mm=80.0)
    arrivals = drive(case)
    assert [arrival.outcome for arrival in arrivals] == ["Success"] * 4
    assert not any(arrival.false for arrival in arrivals)
