"""The map of a world, as a lidar at a given height would survey it."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.simulation.world_files.world_map import NoMap, map_of_world

ROOM = {
    "format": "handcart-world/1",
    "start": {"x_m": 1.0, "y_m": 1.0},
    "walls": [{"from_m": [0, 0], "to_m": [3, 0]}],
    "tables": [{"name": "t", "x_m": 1.0, "y_m": 2.0, "size_m": [0.8, 0.6, 0.4], "foot_m": [0.2, 0.2]}],
    "furniture": [
        {"name": "lamp", "x_m": 2.5, "y_m": 2.0, "size_m": [0.2, 0.2, 0.2], "above_m": 1.5},
        {"name": "crate", "x_m": 2.0, "y_m": 3.0, "heading_deg": 90, "size_m": [0.6, 0.2, 0.5]},
    ],
    "surprises": [{"name": "pallet", "x_m": 2.0, "y_m": 1.0, "size_m": [0.4, 0.4, 0.5]}],
}


def test_map_shows_all_at_the_height_but_no_surprise() -> None:
    grid = map_of_world(WorldFile.model_validate(ROOM), 0.2, 0.05)
    inside = np.array([[1.5, 0.0], [1.0, 2.0], [2.0, 3.2]])
    outside = np.array([[1.3, 2.0], [2.5, 2.0], [2.3, 3.0], [2.0, 1.0]])  # slab, lamp, beside, surprise
    assert all(grid.occupied[tuple(cell)] for cell in grid.to_cell(inside))
    assert not any(grid.occupied[tuple(cell)] for cell in grid.to_cell(outside))
    assert (grid.origin_x, grid.origin_y) == pytest.approx((-0.25, -0.25))
    assert grid.inside(np.array([[3.2, 3.4], [-0.2, -0.2]])).all()


def test_map_at_another_height_shows_slab_and_lamp() -> None:
    world = WorldFile.model_validate(ROOM)
    slab, lamp = np.array([[1.3, 2.0]]), np.array([[2.5, 2.0]])
    at_slab, at_lamp = map_of_world(world, 0.38, 0.05), map_of_world(world, 1.6, 0.05)
    assert at_slab.occupied[tuple(at_slab.to_cell(slab)[0])]
    assert at_lamp.occupied[tuple(at_lamp.to_cell(lamp)[0])]


@pytest.mark.parametrize(
    ("height", "resolution", "words"), [(2.5, 0.05, "nothing in the world"), (0.2, 0.0001, "cells")]
)
def test_map_that_cannot_be_drawn_is_refused(height: float, resolution: float, words: str) -> None:
    with pytest.raises(NoMap, match=words):
        map_of_world(WorldFile.model_validate(ROOM), height, resolution)
