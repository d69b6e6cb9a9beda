from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.maps.map_walls import LONE_POST_CELLS, THIN_WALL_CELLS, map_walls
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

CELL = 0.05
ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)


def grid(*rows: str) -> GridMap:
    """Row 0, the lowest, first; # is occupied."""
    occupied = np.array([[letter == "#" for letter in row] for row in rows])
    return GridMap(occupied, np.zeros_like(occupied), CELL, 1.0, 2.0)


def cells(found: np.ndarray) -> list[list[float]]:
    """Middle column and row, yaw in degrees, length and width in cells."""
    middle = (found[:, :2] - (1.0, 2.0)) / CELL - 0.5
    rows: list[list[float]] = (
        np.column_stack([middle, np.degrees(found[:, 2]), found[:, 3:] / CELL]).round(6).tolist()
    )
    return rows


def test_a_block_reaches_from_centre_to_centre_of_its_outermost_cells() -> None:
    assert cells(map_walls(grid(".....", ".####", ".####", ".####"))) == [[2.5, 2.0, 0.0, 3.0, 2.0]]


@pytest.mark.parametrize(
    ("rows", "middle", "yaw", "length"),
    [
        (("....", "###."), [1.0, 1.0], 0.0, 2.0),
        ((".#.", ".#.", ".#."), [1.0, 1.0], 90.0, 2.0),
        (("#..", ".#.", "..#"), [1.0, 1.0], 45.0, 2 * np.sqrt(2)),
        (("..#", ".#.", "#.."), [1.0, 1.0], 135.0, 2 * np.sqrt(2)),
    ],
)
def test_a_wall_of_one_cell_is_thin_and_solid(
    rows: tuple[str, ...], middle: list[float], yaw: float, length: float
) -> None:
    assert cells(map_walls(grid(*rows))) == [
        pytest.approx([*middle, yaw, length + THIN_WALL_CELLS, THIN_WALL_CELLS], abs=1e-5)
    ]


def test_a_lone_cell_is_a_post_and_an_empty_map_has_nothing() -> None:
    assert cells(map_walls(grid("...", "..#"))) == [[2.0, 1.0, 0.0, LONE_POST_CELLS, LONE_POST_CELLS]]
    assert map_walls(grid("...", "...")).shape == (0, 5)
    assert cells(map_walls(grid("#"))) == [[0.0, 0.0, 0.0, LONE_POST_CELLS, LONE_POST_CELLS]]


@pytest.mark.parametrize("seed", range(12))
def test_what_the_cells_divide_the_walls_divide_and_nothing_else(seed: int) -> None:
    rng = np.random.default_rng(seed)
    occupied = np.pad(rng.random((22, 25)) < rng.uniform(0.2, 0.7), 1)
    chart = GridMap(occupied, np.zeros_like(occupied), CELL, 0.0, 0.0)
    fine = 21  # odd, so that a fine cell has its centre on that of a cell
    size = (occupied.shape[1] * CELL, occupied.shape[0] * CELL)
    drawn = from_boxes(map_walls(chart), CELL / fine, (0.0, 0.0), size)
    assert drawn.occupied[fine // 2 :: fine, fine // 2 :: fine].astype(int).tolist() == occupied.tolist()
    _, coarse_part = cv2.connectedComponents((~occupied).view(np.uint8), connectivity=4)
    _, fine_part = cv2.connectedComponents((~drawn.occupied).view(np.uint8), connectivity=4)
    sampled = fine_part[fine // 2 :: fine, fine // 2 :: fine]
    pairs = {(int(a), int(b)) for a, b in zip(coarse_part.ravel(), sampled.ravel(), strict=True)}
    assert len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs})


@pytest.mark.parametrize(("name", "pose"), [("turtlebot3", (-2.0, 0.0)), ("depot", (16.9, 4.4))])
def test_rays_end_where_scan_matching_reads_the_surfaces(
    name: str, pose: tuple[float, float], request: pytest.FixtureRequest
) -> None:
    chart = request.getfixturevalue(name)
    ranges = box_ranges([tuple(row) for row in map_walls(chart)], Pose2(*pose, 0.3), ANGLES)
    seen = np.isfinite(ranges)
    ends = np.column_stack([ranges * np.cos(ANGLES), ranges * np.sin(ANGLES)])[seen]
    distance = LikelihoodField(chart).read(Pose2(*pose, 0.3).apply(ends))
    assert distance.max() < 0.6 * chart.resolution
    assert distance.mean() < 0.2 * chart.resolution
