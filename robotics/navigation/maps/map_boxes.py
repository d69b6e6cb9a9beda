"""Occupied cells of a map, near a point, as a few rectangles."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .grid_map import FloorBox, GridMap

OUTLINE_BITS = 8  # binary places of a cell in which outlines are drawn


def boxes_near(
    grid: GridMap,
    point: tuple[float, float],
    reach: float,
    hidden: Sequence[FloatArray],
    margin: float = 0.0,
    most: int = 60,
) -> list[FloorBox]:
    """Return rectangles that cover the occupied cells around a point.

    If more than `most` rectangles were needed, as along a slanted wall, the rectangles cover square blocks of
    cells with sides of two, four or more cells. A block is covered if one of its cells is occupied.

    Args:
        grid: the map.
        point: x and y on the map, in [m].
        reach: half the side of the square around the point, in [m].
        hidden: outlines (n, 2) on the map, in [m]; cells whose centre is inside of one are skipped.
        margin: distance around the outlines within which cells are skipped too, in [m].
        most: maximum number of rectangles.
    """
    low, high = grid.to_cell(np.array([point]) + np.array([[-reach], [reach]]))
    low, high = np.clip([low, high + 1], 0, grid.occupied.shape)
    corner = low[::-1] * grid.resolution + (grid.origin_x, grid.origin_y)
    cells = grid.occupied[low[0] : high[0], low[1] : high[1]].copy()
    if not cells.any():
        return []
    outlines = [(outline - corner) / grid.resolution for outline in hidden]
    cells &= ~_covered(cells.shape, outlines, margin / grid.resolution)
    side = grid.resolution
    found = _rectangles(cells)
    while len(found) > most:
        cells, side = _halved(cells), 2.0 * side
        found = _rectangles(cells)
    return [_on_floor(rectangle, corner, side) for rectangle in found]


def _covered(shape: tuple[int, ...], outlines: Sequence[FloatArray], margin: float) -> BoolArray:
    """Return a mask (h, w) of the cells inside of outlines (n, 2) or within a margin of one, all in cells."""
    around = math.ceil(margin) + 1
    away = np.ones((shape[0] + 2 * around, shape[1] + 2 * around), dtype=np.uint8)
    for outline in outlines:
        points = np.round((outline - 0.5 + around) * 2.0**OUTLINE_BITS).astype(np.int32)
        cv2.fillPoly(away, [points], 0, shift=OUTLINE_BITS)
    distance = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(distance[around:-around, around:-around] <= margin)


def _halved(cells: BoolArray) -> BoolArray:
    """Return the cells in blocks of two by two, occupied if one of them is."""
    even = np.pad(cells, [(0, cells.shape[0] % 2), (0, cells.shape[1] % 2)])
    return np.asarray(even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2).any(axis=(1, 3)))


def _rectangles(cells: BoolArray) -> list[tuple[int, int, int, int]]:
    """Return rectangles that cover the occupied cells exactly: first row and column, last ones plus 1."""
    growing: dict[tuple[int, int], int] = {}
    done: list[tuple[int, int, int, int]] = []
    for row, runs in enumerate([*_runs(cells), set()]):
        ended = [run for run in growing if run not in runs]
        done += [(growing.pop(run), run[0], row, run[1]) for run in ended]
        for run in sorted(runs):
            growing.setdefault(run, row)
    return done


def _runs(cells: BoolArray) -> list[set[tuple[int, int]]]:
    """Return the first column and the last one plus 1 of each run of occupied cells, for each row."""
    beside = np.pad(cells, ((0, 0), (1, 1)))
    rows, columns = np.nonzero(beside[:, 1:] != beside[:, :-1])
    runs: list[set[tuple[int, int]]] = [set() for _ in cells]
    for row, first, end in zip(
        rows[::2].tolist(), columns[::2].tolist(), columns[1::2].tolist(), strict=True
    ):
        runs[row].add((first, end))
    return runs


def _on_floor(rectangle: tuple[int, int, int, int], corner: FloatArray, side: float) -> FloorBox:
    """Return a rectangle of cells with a side in [m] as one on the map, of which `corner` (2,) is the
    corner.
    """
    row, column, last_row, last_column = rectangle
    x, y = corner + side * np.array([(column + last_column) / 2, (row + last_row) / 2])
    return FloorBox(float(x), float(y), 0.0, side * (last_column - column), side * (last_row - row))
