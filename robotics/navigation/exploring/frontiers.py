"""Frontiers of a map (Yamauchi, 1997): where known free ground ends, and the robot could drive on.

A cell of the border between free and unknown ground counts if the middle of the robot could be there for all
that is known: no occupied cell is nearer than its radius, and a way of such cells, known or not, leads there.
So a gap that is narrower than the robot does not count as a frontier.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray
from handcart.robotics.numerics.compiled import compiled

TRAVEL_ROOM_M = 0.02
"""Room beside the robot's circle that its routes keep."""
VIEW_ROOM_M = 0.06
"""Room beside the robot's circle at places from which it looks at a frontier."""
VIEW_M = 1.5
"""Distance along free ground from a frontier within which the robot must be able to look at it."""
HALF_CELL = 0.5
"""Distance from the centre of a cell to its side, in [cells]."""
ALL_AROUND = np.ones((3, 3), np.uint8)
"""Kernel of a cell and its eight neighbours."""


class Frontier(NamedTuple):
    """Connected part of the border between free and unknown ground that the robot could cross."""

    middle: tuple[float, float]
    """Centre of the frontier's cell that is nearest to its centre of mass, x and y on the map, in [m]."""
    size: float
    """Diagonal of its bounding box, in [m]."""
    cells: FloatArray
    """Centres (n, 2) of the frontier's cells on the map, in [m]."""
    view: tuple[float, float] | None
    """Nearest place on the map from which the robot can look at it, in [m]; None if it cannot get near."""
    distance: float
    """Length of the way to `view`, in [m]; infinite without one."""


class Border(NamedTuple):
    """Border between free and unknown ground, with the frontiers in it and counts of its cells."""

    frontiers: list[Frontier]
    """Parts that the robot could cross, at least as long as its radius."""
    cells: int
    """Number of border cells that belong to free ground connected with the robot's."""
    passable: int
    """Number of border cells that the robot's middle could cross."""
    small: int
    """Number of passable cells in parts that are shorter than the robot's radius."""
    left: list[int]
    """Number of passable cells around each point at which the border is left as it is."""
    free_m2: float
    """Area of all free ground on the map."""


def find_border(
    grid: GridMap, radius: float, here: tuple[float, float], left: FloatArray, left_radius: float
) -> Border:
    """Find the frontiers of a map.

    Args:
        grid: the map.
        radius: radius of the robot's footprint, in [m].
        here: position of the robot in the frame of the map, in [m].
        left: (n, 2) points in the frame of the map, in [m], around which no frontiers are reported.
        left_radius: radius of the regions around these points, in [m].

    Returns:
        Frontiers outside the regions around `left`, and numbers of cells of the border between free and
            unknown ground: all, passable for the robot, in parts too short, and around each point of `left`.
    """
    free = ~grid.blocked
    row, column = _clipped(grid, here)
    unknown = np.pad(grid.unknown, 1, constant_values=True).astype(np.uint8)  # so is what is off the map
    border = free & (cv2.dilate(unknown, ALL_AROUND)[1:-1, 1:-1] > 0)
    border &= _connected(free, row, column, radius / grid.resolution)
    could_be = _clearance(~grid.occupied, True) >= (radius + TRAVEL_ROOM_M) / grid.resolution + HALF_CELL
    passable = border & _connected(could_be, row, column, radius / grid.resolution + 2.0)
    count = int(passable.sum())
    counts = [_take_out(grid, passable, point, left_radius) for point in left]
    clearance = (_clearance(free, False) - HALF_CELL) * grid.resolution
    way = _connected(clearance >= radius + TRAVEL_ROOM_M, row, column, 2.0 * radius / grid.resolution + 2.0)
    start = _nearest(way, row, column)
    lengths = np.full(free.shape, np.inf) if start is None else travel(way, *start)
    lengths[clearance < radius + VIEW_ROOM_M] = np.inf
    parts = _clusters(passable, border, radius / grid.resolution)
    found = [_frontier(grid, cells, free, lengths) for cells in parts]
    small = count - sum(counts) - sum(map(len, parts))
    area = float(np.count_nonzero(free)) * grid.resolution**2
    return Border(found, int(border.sum()), count, small, counts, area)


def _take_out(grid: GridMap, flags: BoolArray, point: FloatArray, radius: float) -> int:
    """Clear the cells around a point (2,) in [m]; return their number."""
    cells = np.argwhere(flags)
    near = cells[np.hypot(*(grid.to_point(cells) - point).T) < radius]
    flags[near[:, 0], near[:, 1]] = False
    return len(near)


def _clipped(grid: GridMap, point: tuple[float, float]) -> tuple[int, int]:
    cell = np.clip(grid.to_cell(np.array([point]))[0], 0, np.array(grid.occupied.shape) - 1)
    return int(cell[0]), int(cell[1])


def _clearance(open_: BoolArray, is_open_beyond: bool) -> FloatArray:
    """Return the distance (h, w), in cells, of each cell's centre to the nearest centre that is not open.

    Cells off the map are open or not.
    """
    padded = np.pad(open_, 1, constant_values=is_open_beyond).astype(np.uint8)
    found = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(found[1:-1, 1:-1], dtype=np.float64)


def _nearest(flags: BoolArray, row: int, column: int) -> tuple[int, int] | None:
    cells = np.argwhere(flags)
    if not len(cells):
        return None
    nearest = cells[np.argmin(np.hypot(*(cells - (row, column)).T))]
    return int(nearest[0]), int(nearest[1])


def _connected(flags: BoolArray, row: int, column: int, within: float) -> BoolArray:
    """Return a mask (h, w) of the connected cells nearest to one; none if farther than `within` cells."""
    nearest = _nearest(flags, row, column)
    if nearest is None or math.dist(nearest, (row, column)) > within:
        return np.zeros_like(flags)
    _, labels = cv2.connectedComponents(flags.astype(np.uint8), connectivity=4)
    return np.asarray(labels == labels[nearest])


def _clusters(passable: BoolArray, border: BoolArray, least: float) -> list[IntArray]:
    """Return the passable cells (n, 2) of each connected part of the border.

    Parts are skipped whose bounding box has a diagonal of less than `least` cells.
    """
    _, labels = cv2.connectedComponents(cv2.dilate(border.astype(np.uint8), ALL_AROUND), connectivity=8)
    cells = np.argwhere(border)
    numbers = labels[cells[:, 0], cells[:, 1]]
    order = np.argsort(numbers, kind="stable")
    parts = np.split(cells[order], np.flatnonzero(np.diff(numbers[order])) + 1)
    large = (part for part in parts if len(part) and float(np.hypot(*np.ptp(part, axis=0))) + 1.0 >= least)
    crossed = (part[passable[part[:, 0], part[:, 1]]] for part in large)
    return [part for part in crossed if len(part)]


def _frontier(grid: GridMap, cells: IntArray, free: BoolArray, lengths: FloatArray) -> Frontier:
    middle = cells[np.argmin(np.hypot(*(cells - cells.mean(axis=0)).T))]
    points = grid.to_point(cells)
    size = float(np.hypot(*np.ptp(points, axis=0))) + grid.resolution
    view, distance = _view(grid, cells, free, lengths)
    x, y = grid.to_point(middle[None])[0].tolist()
    return Frontier((x, y), size, points, view, distance)


def _view(
    grid: GridMap, cells: IntArray, free: BoolArray, lengths: FloatArray
) -> tuple[tuple[float, float] | None, float]:
    """Return the place from which a part of the border can be looked at, and the way to it, in [m]."""
    steps = math.ceil(VIEW_M / grid.resolution)
    low = np.maximum(cells.min(axis=0) - steps, 0)
    high = np.minimum(cells.max(axis=0) + steps + 1, free.shape)
    window = slice(low[0], high[0]), slice(low[1], high[1])
    near, ground = np.zeros(tuple(high - low), np.uint8), free[window].astype(np.uint8)
    near[tuple((cells - low).T)] = 1
    reachable = np.isfinite(lengths[window])
    for _ in range(steps):
        there = (near > 0) & reachable
        if there.any():
            found = np.argwhere(there)
            at = found[np.argmin(lengths[window][there])] + low
            x, y = grid.to_point(at[None])[0].tolist()
            return (x, y), float(lengths[tuple(at)]) * grid.resolution
        near = np.asarray(cv2.dilate(near, ALL_AROUND), dtype=np.uint8) & ground
    return None, math.inf


@compiled
def travel(free: BoolArray, row: int, column: int) -> FloatArray:
    """Return the lengths (h, w), in cells, of the shortest ways from a cell to all cells; infinite without a
    way.

    Ways lead over free cells, from each to its eight neighbours. Cells are expanded roughly in the order of
    their distances, sorted into buckets one cell wide (Dial, 1969).

    Args:
        free: (h, w) True for free cells.
        row: row of the cell at which all ways begin.
        column: column of that cell.
    """
    height, width = free.shape
    lengths = np.full((height, width), np.inf)
    lengths[row, column] = 0.0
    now = [(row, column)]
    later = [(row, column)]
    later.clear()
    limit = 1.0
    while len(now) > 0 or len(later) > 0:
        while len(now) > 0:
            r, c = now.pop()
            here = lengths[r, c]
            for i in range(-1, 2):
                for j in range(-1, 2):
                    nr, nc = r + i, c + j
                    if nr < 0 or nc < 0 or nr >= height or nc >= width or not free[nr, nc]:
                        continue
                    length = here + (1.0 if i == 0 or j == 0 else 1.4142135623730951)
                    if length < lengths[nr, nc] - 1e-9:
                        lengths[nr, nc] = length
                        if length < limit:
                            now.append((nr, nc))
                        else:
                            later.append((nr, nc))
        now, later = later, now
        limit += 1.0
    return lengths
