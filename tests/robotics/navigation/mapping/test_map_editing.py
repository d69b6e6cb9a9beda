"""Map tools keep what they do not change, whatever the map: crop, turn, zones, writing, comparison."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from handcart.files.maps.map_file import load_map
from handcart.files.maps.map_writing import write_grid
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.map_comparison import compare_maps
from handcart.robotics.navigation.mapping.map_editing import (
    NothingLeft,
    crop_to,
    crop_to_known,
    paint_zone,
    turn,
)
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

UNHURRIED = settings(deadline=None, derandomize=True, max_examples=40)
coordinates = st.floats(-9.0, 9.0, allow_nan=False)
points = st.tuples(coordinates, coordinates)


@st.composite
def grids(draw: st.DrawFn) -> GridMap:
    """Small maps with cells of any kind and any size, anywhere."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    shape = draw(st.integers(1, 40)), draw(st.integers(1, 40))
    kinds = rng.choice(3, shape, p=(0.6, 0.2, 0.2))
    resolution = draw(st.sampled_from((0.03, 0.05, 0.1, 0.25)))
    x, y = draw(points)
    return GridMap(kinds == 1, kinds == 2, resolution, round(x, 3), round(y, 3))


def kinds_at(grid: GridMap, where: np.ndarray) -> list[tuple[bool, bool]]:
    rows, columns = grid.to_cell(where).T
    return list(zip(grid.occupied[rows, columns].tolist(), grid.unknown[rows, columns].tolist(), strict=True))


def centres(grid: GridMap) -> np.ndarray:
    return grid.to_point(np.argwhere(np.ones_like(grid.occupied)))


@UNHURRIED
@given(grids(), points, points)
def test_cropped_map_has_all_cells_of_its_rectangle(
    grid: GridMap, one: tuple[float, float], other: tuple[float, float]
) -> None:
    low, high = np.minimum(one, other), np.maximum(one, other)
    inside = centres(grid)
    inside = inside[((inside > low) & (inside < high)).all(axis=1)]
    try:
        part = crop_to(grid, tuple(low.tolist()), tuple(high.tolist()))
    except NothingLeft:
        assert not len(inside)
        return
    assert part.inside(inside).all()
    assert kinds_at(part, centres(part)) == kinds_at(grid, centres(part))
    again = crop_to(part, tuple(low.tolist()), tuple(high.tolist()))
    assert (again.occupied.shape, again.origin_x, again.origin_y) == (
        part.occupied.shape,
        part.origin_x,
        part.origin_y,
    )


@UNHURRIED
@given(grids())
def test_map_without_its_unknown_edges_keeps_what_is_known(grid: GridMap) -> None:
    assume((~grid.unknown).any())
    part = crop_to_known(grid)
    assert np.count_nonzero(~part.unknown) == np.count_nonzero(~grid.unknown)
    assert kinds_at(part, centres(part)) == kinds_at(grid, centres(part))


@UNHURRIED
@given(grids(), st.integers(1, 3))
def test_quarter_turns_of_a_map_lead_back(grid: GridMap, count: int) -> None:
    turned = turn(grid, count * math.pi / 2)
    back = turn(turned, -count * math.pi / 2)
    assert np.count_nonzero(turned.occupied) == np.count_nonzero(grid.occupied)
    assert kinds_at(back, centres(grid)) == kinds_at(grid, centres(grid))


@UNHURRIED
@given(st.floats(-3.1, 3.1), points)
def test_turned_walls_are_where_the_turn_leads(angle: float, corner: tuple[float, float]) -> None:
    grid = from_boxes([(*corner, 0.3, 2.0, 1.0)], 0.05, (corner[0] - 2.0, corner[1] - 2.0), (4.0, 4.0))
    turned = turn(grid, angle)
    walls = Pose2(0.0, 0.0, angle).apply(grid.to_point(np.argwhere(grid.occupied)))
    there = turned.to_point(np.argwhere(turned.occupied))
    from scipy.spatial import cKDTree

    assert cKDTree(there).query(walls)[0].max() < 0.05
    assert cKDTree(walls).query(there)[0].max() < 0.05


@UNHURRIED
@given(grids(), st.lists(points, min_size=3, max_size=6))
def test_zone_that_is_taken_away_leaves_no_trace(grid: GridMap, corners: list[tuple[float, float]]) -> None:
    nothing = np.zeros_like(grid.occupied)
    empty = grid._replace(occupied=nothing, unknown=nothing)
    zones = paint_zone(empty, corners, True)
    assert not paint_zone(zones, corners, False).occupied.any()
    assert (paint_zone(zones, corners, True).occupied == zones.occupied).all()


@UNHURRIED
@given(grids())
def test_written_map_is_read_back(grid: GridMap) -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_grid(Path(folder) / "map.yaml", grid)
        read, warning = load_map(Path(folder) / "map.yaml")
    assert (warning is None) == (~grid.occupied & ~grid.unknown).any()
    assert (read.occupied == grid.occupied).all()
    assert (read.unknown == grid.unknown).all()
    assert read[2:] == pytest.approx(grid[2:])


@pytest.mark.slow
@settings(deadline=None, derandomize=True, max_examples=5)
@given(st.floats(-3.1, 3.1), points)
def test_moved_map_is_found_where_it_was_moved(angle: float, shift: tuple[float, float]) -> None:
    boxes = [(0.0, y, 0.0, 8.0, 0.1) for y in (-3.0, 3.0)] + [(x, 0.0, 0.0, 0.1, 6.0) for x in (-4.0, 4.0)]
    boxes += [(1.5, 1.0, 0.4, 1.4, 0.6), (-2.5, -2.0, 0.0, 0.4, 1.8), (-1.0, 2.6, 0.0, 1.0, 0.6)]
    grid = from_boxes(boxes, 0.05, (-4.5, -3.5), (9.0, 7.0))
    moved = turn(grid, angle)
    moved = moved._replace(origin_x=moved.origin_x + shift[0], origin_y=moved.origin_y + shift[1])
    found = compare_maps(grid, moved)
    expected = Pose2(*shift, angle).inverse()
    assert found.first_T_second.distance(expected) < 0.03 + 0.01 * math.hypot(*shift)
    assert found.first_T_second.turn(expected) < math.radians(0.5)
    back = compare_maps(moved, grid)
    assert back.first_T_second.compose(found.first_T_second).distance(Pose2(0.0, 0.0, 0.0)) < 0.15
