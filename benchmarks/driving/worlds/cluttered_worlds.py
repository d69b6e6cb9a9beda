"""Halls full of posts, for `cluttered`: a cellular automaton, start and goal 10 m apart, all by a seed."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from benchmarks.driving.pose_lattice import is_connected
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.routes.route import Route, plan_route
from handcart.robotics.navigation.routes.voronoi_graph import voronoi_graph
from handcart.robotics.numerics.arrays import BoolArray

LENGTH_M, WIDTH_M, WALL_M = 14.0, 4.8, 0.1  # of the hall
START, GOAL = (2.0, 2.4, 0.0), (12.0, 2.4, 0.0)  # x, y in [m], heading in [deg]
FIRST_M, LAST_M = 3.2, 11.0  # x of the hall in which posts are
POST_M = 0.15  # side of a cell of the automaton
DENSITIES = (0.14, 0.20, 0.26)  # shares of cells that are posts before the automaton smooths them
SMOOTHING_STEPS = 2
CROWDED, LONELY = 5, 1  # posts among 8 neighbours: no fewer become a post, no more leave none
EXACT_CELL_M = 0.01  # cells of the map that says whether a way exists, and how long it is
FLOOD_CELL_M = 0.02  # of the map on which poses of a polygon are connected
WAY_ROOM_M = 0.05  # beside the footprint that a world's best way has
MAX_TRIES = 200
Box = tuple[float, float, float, float, float]
"""x, y, heading in [rad], length and width, in [m]."""


class World(NamedTuple):
    """A hall with posts through which a way leads."""

    seed: int
    density: float
    posts: list[Box]
    best: Route
    """Short way with room for the footprint, on a map of everything."""


def make_world(seed: int, density: float, shape: Footprint) -> World:
    """Return the world of a seed and a density for a footprint.

    Raises:
        RuntimeError: no draw of the seed leaves a way.
    """
    rng = np.random.default_rng([seed, round(1e3 * density)])
    for _ in range(MAX_TRIES):
        posts = _boxes(_automaton(rng, density))
        best = _best_way(posts, shape)
        if best is not None:
            return World(seed, density, posts, best)
    raise RuntimeError(f"no way through world {seed} of density {density}")


def walls() -> list[Box]:
    """Return the four walls of the hall."""
    x, y = LENGTH_M / 2, WIDTH_M / 2
    flat: list[Box] = [(x, side, 0.0, LENGTH_M + WALL_M, WALL_M) for side in (0.0, WIDTH_M)]
    return flat + [(side, y, 0.0, WALL_M, WIDTH_M) for side in (0.0, LENGTH_M)]


def hall_map(boxes: list[Box], cell: float, seed: int | None = None) -> GridMap:
    """Return a map with these boxes and cells of `cell` in [m]; it ends outside of the walls.

    With a seed the walls lie anywhere in their cells, as on a real map.
    """
    x, y = (0.0, 0.0) if seed is None else np.random.default_rng(seed).uniform(-cell, 0.0, 2).tolist()
    return from_boxes(boxes, cell, (-0.3 + x, -0.3 + y), (LENGTH_M + 0.7, WIDTH_M + 0.7))


def _automaton(rng: np.random.Generator, density: float) -> BoolArray:
    """Return (h, w) cells that are posts."""
    shape = (round(WIDTH_M / POST_M), round((LAST_M - FIRST_M) / POST_M))
    posts = rng.random(shape) < density
    ring = np.ones((3, 3))
    ring[1, 1] = 0.0
    for _ in range(SMOOTHING_STEPS):
        around = cv2.filter2D(posts.astype(np.float64), -1, ring, borderType=cv2.BORDER_CONSTANT)
        posts = (around >= CROWDED) | (posts & (around > LONELY))
    return posts


def _boxes(posts: BoolArray) -> list[Box]:
    """Return a box for each run of posts along a row."""
    found: list[Box] = []
    for row, cells in enumerate(posts):
        ends = np.flatnonzero(np.diff(np.concatenate([[0], cells.astype(np.int8), [0]])))
        for first, last in ends.reshape(-1, 2).tolist():
            middle = FIRST_M + POST_M * (first + last) / 2
            found.append((middle, POST_M * (row + 0.5), 0.0, POST_M * (last - first), POST_M))
    return found


def _best_way(posts: list[Box], shape: Footprint) -> Route | None:
    """Return a short way for the inscribed disc, if the footprint can get to the goal at all."""
    grid = hall_map([*walls(), *posts], EXACT_CELL_M)
    try:
        graph = voronoi_graph(grid, shape.inscribed + WAY_ROOM_M, seed_point=START[:2])
    except ValueError:
        return None
    if not shape.is_disc:
        coarse = hall_map([*walls(), *posts], FLOOD_CELL_M)
        if not is_connected(coarse, shape, START[:2], GOAL[:2], WAY_ROOM_M - FLOOD_CELL_M):
            return None
    return plan_route(graph, START[:2], GOAL[:2], 0.0)


def write_world(
    world: World, folder: Path, mapped: list[Box], cell: float, tolerance: tuple[float, float]
) -> None:
    """Write map, world and places of a world.

    Args:
        world: the world.
        folder: existing folder for the files.
        mapped: boxes that the map shows.
        cell: side of a cell of the map, in [m].
        tolerance: tolerance of the goal in [mm] and [deg].
    """
    map_text(hall_map(mapped, cell, world.seed), folder)
    world_text(folder, walls(), world.posts, START, GOAL, tolerance)


def map_text(grid: GridMap, folder: Path) -> None:
    """Write a map into an existing folder, as `map.yaml` and its picture."""
    cv2.imwrite(str(folder / "map.png"), np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1])
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {grid.resolution}\norigin: [{grid.origin_x}, {grid.origin_y}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


def world_text(
    folder: Path,
    furniture: list[Box],
    surprises: list[Box],
    begin: tuple[float, float, float],
    end: tuple[float, float, float],
    tolerance: tuple[float, float],
) -> None:
    """Write `world.yaml` and `places.yaml` with the places `home` and `goal` into an existing folder.

    Args:
        folder: for the files.
        furniture: boxes that the map may show.
        surprises: boxes that it does not show.
        begin: start: x, y in [m], heading in [deg].
        end: goal, likewise.
        tolerance: tolerance of the goal in [mm] and [deg].
    """
    x, y, heading = begin
    start = f"format: handcart-world/1\nstart: {{x_m: {x}, y_m: {y}, heading_deg: {heading}}}\n"
    (folder / "world.yaml").write_text(
        start + _listed("furniture", "wall", furniture) + _listed("surprises", "post", surprises)
    )
    lines = [
        f"  {name}: {{x_m: {x}, y_m: {y}, heading_deg: {turn}, tolerance_mm: {tolerance[0]}, "
        f"tolerance_deg: {tolerance[1]}}}\n"
        for name, (x, y, turn) in (("home", begin), ("goal", end))
    ]
    (folder / "places.yaml").write_text("format: handcart-places/1\nplaces:\n" + "".join(lines))


def _listed(key: str, name: str, boxes: list[Box]) -> str:
    lines = [
        f"  - {{name: {name} {i}, x_m: {x:.4f}, y_m: {y:.4f}, heading_deg: {math.degrees(yaw):.3f}, "
        f"size_m: [{length:.4f}, {width:.4f}, 0.8]}}\n"
        for i, (x, y, yaw, length, width) in enumerate(boxes)
    ]
    return f"{key}:\n" + "".join(lines) if lines else ""


def dead_end(depth: float = 3.0, width: float = 2.0) -> list[Box]:
    """Return a U of posts that opens towards the start, across the straight way."""
    back, wall = 8.0, 0.15
    middle, y = back - depth / 2, START[1]
    sides: list[Box] = [(middle, y + side * (width + wall) / 2, 0.0, depth, wall) for side in (-1.0, 1.0)]
    return [*sides, (back, y, 0.0, wall, width + 2 * wall)]


def closed_wall() -> list[Box]:
    """Return posts across all of the hall."""
    edges = np.linspace(0.0, WIDTH_M, 13)
    return [(7.0, (low + high) / 2, 0.0, POST_M, high - low) for low, high in pairwise(edges.tolist())]
