"""Exact distances to what a map shows, against every cell looked at."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.grid_map import GridMap

EMPTY = np.zeros((4, 5), dtype=np.bool_)


@pytest.mark.parametrize("walled", [False, True])
def test_distances_are_those_to_the_squares_of_the_cells(walled: bool) -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        shape = rng.integers(1, 30, 2)
        solid = rng.random(shape) < rng.choice([0.01, 0.1, 0.5])
        grid = GridMap(solid, np.zeros_like(solid), float(rng.choice([0.05, 0.2])), 1.0, -2.0)
        beside = 0 if walled else 3
        points = grid.to_point(rng.uniform(-beside, shape - 1 + beside, (50, 2)))
        found, chart = Clearances(grid, walled=walled).at(points), np.pad(solid, 1, constant_values=True)
        cells = np.argwhere(chart if walled else solid) - int(walled)
        if len(cells) == 0:
            assert np.isinf(found).all()
            continue
        low = cells[:, ::-1] * grid.resolution + (1.0, -2.0)
        beyond = np.maximum(low[None] - points[:, None], points[:, None] - low[None] - grid.resolution)
        assert found == pytest.approx(np.hypot(*np.maximum(beyond, 0.0).transpose(2, 0, 1)).min(axis=1))


def test_what_is_nearest_is_told_with_its_place() -> None:
    solid = EMPTY.copy()
    solid[2, 4] = True
    nearest = Clearances(GridMap(solid, EMPTY, 0.1, 0.0, 0.0)).nearest((0.1, 0.25))
    assert nearest.distance == pytest.approx(0.3)
    assert nearest.point == pytest.approx([0.4, 0.25])


def test_on_an_empty_map_nothing_is_near() -> None:
    assert np.isinf(Clearances(GridMap(EMPTY, EMPTY, 0.1, 0.0, 0.0)).nearest((0.1, 0.1)).distance)
