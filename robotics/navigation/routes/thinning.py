"""Thinning in the order of distance: a skeleton with exactly the topology of the free space.

A cell is *simple* when removing it changes neither the 8-connected components of the free cells nor the
4-connected components of the others (Yokoi's connectivity number for 8-neighbourhoods is one). Simple cells
are removed one after the other, nearest to an obstacle first (Pudney, 1998), so what is left is centred and
has the topology that it started with, by construction. Ridges of the distance (between obstacles on two
sides, or into a corner) are kept in a first pass, so that ways into rooms without a second door survive; a
second pass thins the ridges themselves.
"""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import (
    BoolArray,
    ByteArray,
    Int32Array,
    IntArray,
    SingleArray,
)
from handcart.robotics.numerics.compiled import compiled

# slope of the distance: 1 before a wall, 0.71 into a right-angled corner, 0 in a corridor's middle
MAX_RIDGE_SLOPE = 0.8
SQRT_2 = math.sqrt(2.0)
LEVELS_PER_CELL = 16  # finer than a cell's rounding of a distance, coarse enough to sort by counting


def _simple_table() -> BoolArray:
    """Return (256,) whether a cell is simple, by its neighbourhood; bit k is the neighbour at k times 45
    degrees.
    """
    codes = np.arange(256)
    away = 1 - ((codes[:, None] >> np.arange(8)) & 1)
    number = sum(
        away[:, k] - away[:, k] * away[:, (k + 1) % 8] * away[:, (k + 2) % 8] for k in (0, 2, 4, 6)
    )  # Yokoi, Toriwaki and Fukumura (1975), eq. for 8-connection
    return np.asarray(number == 1)


def _removable_table() -> BoolArray:
    """Return (256,) whether a cell is simple and not the end of a line; ends stay, or no branch would."""
    neighbours = np.array([code.bit_count() for code in range(256)])
    return _simple_table() & (neighbours > 1)


SIMPLE_TABLE = _simple_table()
REMOVABLE_TABLE = _removable_table()


def neighbour_steps(width: int) -> IntArray:
    """Return the offsets (8,) of a cell's neighbours in the flat array of a map.

    The step with number k + 4 (modulo 8) is opposite to step k.

    Args:
        width: width of the map, in [cells].
    """
    return np.array([1, width + 1, width, width - 1, -1, -width - 1, -width, -width + 1], dtype=np.int64)


@compiled
def _nearest_first(distance: SingleArray, free: ByteArray) -> Int32Array:
    """Return flat indices (n,) of the free cells by growing distance, ties in raster order."""
    farthest = np.float64(0.0)
    for cell in range(free.size):
        if free[cell]:
            farthest = max(farthest, np.float64(distance[cell]))
    first = np.zeros(int(farthest * LEVELS_PER_CELL) + 2, dtype=np.int64)
    for cell in range(free.size):
        if free[cell]:
            first[int(np.float64(distance[cell]) * LEVELS_PER_CELL) + 1] += 1
    for level in range(1, first.size):
        first[level] += first[level - 1]
    order = np.empty(first[-1], dtype=np.int32)
    for cell in range(free.size):
        if free[cell]:
            level = int(np.float64(distance[cell]) * LEVELS_PER_CELL)
            order[first[level]] = cell
            first[level] += 1
    return order


@compiled
def _ridges(distance: SingleArray, order: Int32Array, steps: IntArray, size: int) -> ByteArray:
    """Return a mask (size,) of cells between two obstacles: ridges of the distance.

    It rises less than `MAX_RIDGE_SLOPE` from there to all sides.
    """
    ridges = np.zeros(size, dtype=np.uint8)
    for cell in order:
        beside, corner = distance[cell + steps[0]], distance[cell + steps[1]]
        for k in range(2, 8, 2):
            beside = max(beside, distance[cell + steps[k]])
            corner = max(corner, distance[cell + steps[k + 1]])
        own = distance[cell]
        if beside - own < MAX_RIDGE_SLOPE and corner - own < MAX_RIDGE_SLOPE * SQRT_2:
            ridges[cell] = 1
    return ridges


@compiled
def _removable(state: ByteArray, cell: np.int64, steps: IntArray, table: BoolArray) -> bool:
    code = 0
    for k in range(8):
        code |= (state[cell + steps[k]] != 0) << k
    return bool(table[code])


@compiled
def _peel(
    state: ByteArray,
    order: Int32Array,
    fixed: ByteArray,
    steps: IntArray,
    table: BoolArray,
) -> None:
    """Remove cells in order; a cell that was kept (2) is tested again when a neighbour is removed.

    The kept cells have the state 1 at the end.
    """
    waiting = np.empty(8 * order.size + 1, dtype=np.int32)  # each removal adds 8 cells at most
    for first in order:
        if fixed[first] or not state[first]:
            continue
        state[first] = 2
        waiting[0], count = first, 1
        while count:
            count -= 1
            cell = np.int64(waiting[count])
            if state[cell] == 2 and _removable(state, cell, steps, table):
                state[cell] = 0
                for k in range(8):
                    neighbour = cell + steps[k]
                    if state[neighbour] == 2:
                        waiting[count] = neighbour
                        count += 1
    for cell in order:
        if state[cell] == 2:
            state[cell] = 1


def thin(free: BoolArray, distance: SingleArray) -> BoolArray:
    """Return the skeleton of the free cells as a mask (h, w).

    The skeleton is one cell wide, has the same connections and holes as the free cells, and runs where the
    distance to the obstacles on both sides is equal.

    Args:
        free: (h, w) mask, False all along the border.
        distance: (h, w) distance of each cell to the nearest obstacle, in [cells].
    """
    flat = np.ascontiguousarray(distance).ravel()
    state = free.astype(np.uint8).ravel()
    order, steps = _nearest_first(flat, state), neighbour_steps(free.shape[1])
    ridges = _ridges(flat, order, steps, free.size)
    _peel(state, order, ridges, steps, SIMPLE_TABLE)
    _peel(state, order, np.zeros_like(state), steps, REMOVABLE_TABLE)
    return state.reshape(free.shape).view(np.bool_)
