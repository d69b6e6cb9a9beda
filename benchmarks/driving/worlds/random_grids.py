"""Random grids to plan on: speckle, rooms, diagonal walls and boxes, with cells of any size."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

NEAREST_COUNT = 12  # centres that are looked at first
# [cells] that squares' distances may differ more than their centres'
DIAGONAL_CELLS = math.sqrt(0.5) - 0.5 + 1e-9
CELLS_PER_RADIUS = (0.0, 0.3, 0.5, 0.6, 0.8, 1.0, 1.3, 1.9, 2.5, 4.0, 7.6)


def speckle(rng: np.random.Generator, shape: tuple[int, int]) -> BoolArray:
    """Lone cells anywhere."""
    lone: BoolArray = rng.random(shape) < rng.choice([0.01, 0.03, 0.1, 0.2, 0.3])
    return lone


def rooms(rng: np.random.Generator, shape: tuple[int, int], room: int = 0, door: int = 0) -> BoolArray:
    """Rooms of `room` cells behind walls one cell thick, with doors of `door` cells; any numbers if 0."""
    room = room or int(rng.integers(4, 16))
    occupied = np.zeros(shape, dtype=np.bool_)
    for walls in (occupied, occupied.T):
        for wall in range(room, len(walls), room + 1):
            walls[wall] = True
    for walls in (occupied, occupied.T):
        for wall in range(room, len(walls), room + 1):
            for low in range(0, walls.shape[1], room + 1):
                wide = min(door or int(rng.integers(1, 4)), room)
                if rng.random() < 0.8:
                    begin = low + int(rng.integers(0, room - wide + 1))
                    walls[wall, begin : begin + wide] = False
    return occupied


def diagonals(rng: np.random.Generator, shape: tuple[int, int]) -> BoolArray:
    """Walls one cell thick that run from corner to corner of their cells, with gaps."""
    occupied = np.zeros(shape, dtype=np.bool_)
    for _ in range(int(rng.integers(2, 9))):
        row, column = (int(rng.integers(size)) for size in shape)
        right = int(rng.choice([-1, 1]))
        along = np.arange(-max(shape), max(shape))
        kept = rng.random(len(along)) > rng.choice([0.0, 0.05, 0.1])
        cells = np.column_stack([row + along, column + right * along])[kept]
        cells = cells[np.all((cells >= 0) & (cells < shape), axis=1)]
        occupied[tuple(cells.T)] = True
    return occupied


def boxes(rng: np.random.Generator, shape: tuple[int, int]) -> BoolArray:
    """Furniture and walls at any angle."""
    size = (float(shape[1]), float(shape[0]))
    many = [
        (
            *rng.uniform((0, 0), size),
            rng.uniform(0, np.pi),
            rng.uniform(0.3, 0.5 * max(shape)),
            rng.uniform(0.1, 4),
        )
        for _ in range(int(rng.integers(3, 15)))
    ]
    return from_boxes(many, 1.0, (0.0, 0.0), size).occupied


def streets(rng: np.random.Generator, shape: tuple[int, int], block: int = 32) -> BoolArray:
    """Blocks of houses, some turned, some missing, with streets between them."""
    size = (float(shape[1]), float(shape[0]))
    houses = [
        (
            x + rng.uniform(0.3, 0.7) * block,
            y + rng.uniform(0.3, 0.7) * block,
            float(rng.choice([0.0, rng.uniform(0.0, np.pi)])),
            *rng.uniform(0.25 * block, 0.9 * block, 2),
        )
        for x in range(0, shape[1], block)
        for y in range(0, shape[0], block)
        if rng.random() < 0.85
    ]
    return from_boxes(houses, 1.0, (0.0, 0.0), size).occupied


GRID_KINDS: tuple[Callable[[np.random.Generator, tuple[int, int]], BoolArray], ...] = (
    speckle,
    rooms,
    diagonals,
    boxes,
)


def random_grid(seed: int) -> tuple[GridMap, float]:
    """Return a grid and the radius of a robot for it, in [m]: none, a part of a cell, up to many cells."""
    rng = np.random.default_rng(seed)
    shape = int(rng.integers(8, 60)), int(rng.integers(8, 60))
    occupied = GRID_KINDS[seed % len(GRID_KINDS)](rng, shape)
    unknown = (rng.random(shape) < 0.05) & ~occupied if rng.random() < 0.2 else np.zeros_like(occupied)
    resolution = float(rng.choice([0.03, 0.05, 0.1, 0.2, 0.25, 0.4, 1.0]))
    grid = GridMap(occupied, unknown, resolution, *rng.uniform(-20.0, 20.0, 2).tolist())
    return grid, float(rng.choice(CELLS_PER_RADIUS)) * resolution


def distance_to_squares(blocked: BoolArray, points: FloatArray) -> FloatArray:
    """Return the (n,) distances of (n, 2) points to the nearest blocked square, in [cells].

    The planner's code is not used. Everything beyond the map is blocked. The nearest square is one of
    those with the nearest centres: a square is nearer than its centre by at least half a cell and at most
    half a cell's diagonal. If too many centres are about equally near, all squares are tried.
    """
    padded = np.pad(blocked, 1, constant_values=True)
    rim = np.argwhere(padded & ~ndimage.binary_erosion(padded, border_value=1))
    cells: FloatArray = rim.astype(np.float64) - 1.0
    if len(cells) == 0:
        return np.zeros(len(points))
    count = min(NEAREST_COUNT, len(cells))
    away, index = cKDTree(cells).query(points, k=np.arange(1, count + 1))
    found: FloatArray = _to_squares(points[:, None], cells[index]).min(axis=1)
    for i in np.flatnonzero((away[:, -1] < away[:, 0] + DIAGONAL_CELLS) & (count < len(cells))):
        found[i] = _to_squares(points[i], cells).min()
    own = np.floor(points + 1.5).astype(np.int64)
    found[padded[own[:, 0], own[:, 1]]] = 0.0
    return found


def _to_squares(points: FloatArray, cells: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(*np.moveaxis(np.maximum(np.abs(points - cells) - 0.5, 0.0), -1, 0)))
