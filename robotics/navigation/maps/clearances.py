"""Exact distances to what a map shows: to the squares of its cells, not to their centres."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled


class Nearest(NamedTuple):
    """Solid cell that is nearest to a given point, with its distance."""

    distance: float
    """Distance to the cell's square in [m]; 0 inside of the cell, inf if the map is empty."""
    point: FloatArray
    """Point (2,) of that cell that is nearest, on the map, in [m]; NaN if the map is empty."""


class Clearances:
    """Distances of points on a map to the nearest solid cell; each solid cell is a solid square.

    Beyond the map's border nothing is solid by default. If `walled` is True, all of the ground there is
    solid.
    """

    def __init__(self, grid: GridMap, solid: BoolArray | None = None, walled: bool = False) -> None:
        """Prepare a map; takes a few milliseconds for 100,000 cells.

        Args:
            grid: the map.
            solid: (h, w) cells that count; the occupied ones if None.
            walled: True if everything beyond the map's border is solid too.
        """
        chosen = grid.occupied if solid is None else solid
        self.solid: BoolArray = np.pad(chosen, int(walled), constant_values=True)
        """(h, w) cells, with a border of them where the map is `walled`."""
        self.resolution = grid.resolution
        """Side of a cell, in [m]."""
        self.origin = np.array([grid.origin_x, grid.origin_y]) - int(walled) * grid.resolution
        """(2,) lower-left corner of `solid`, in [m]."""
        self.empty = not bool(self.solid.any())
        """True if no cell is solid."""
        self.between_centres: SingleArray = np.zeros(self.solid.shape, dtype=np.float32)
        """(h, w) from each cell's centre to that of the nearest solid one, in [cells]."""
        if not self.empty:
            open_ = (~self.solid).astype(np.uint8)
            away = cv2.distanceTransform(open_, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            self.between_centres = np.asarray(away, dtype=np.float32)

    def nearest(self, point: tuple[float, float]) -> Nearest:
        """Return the solid cell nearest to a point (x, y on the map, in [m]), with its distance in [m]."""
        if self.empty:
            return Nearest(math.inf, np.full(2, np.nan))
        x, y = self._scaled(np.array([point[:2]]))[0].tolist()
        distance, column, row = nearest_square(self.solid, self.between_centres, x, y)
        return Nearest(distance * self.resolution, self.origin + self.resolution * np.array([column, row]))

    def at(self, points: FloatArray) -> FloatArray:
        """Return the distance (n,) of points to the nearest solid cell, in [m].

        The distance is 0 inside a solid cell, and infinite if no cell of the map is solid.

        Args:
            points: (n, 2) on the map, in [m].
        """
        if self.empty:
            return np.full(len(points), np.inf)
        found = _distances(
            self.solid, self.between_centres, self._scaled(np.asarray(points, dtype=np.float64))
        )
        return np.asarray(found * self.resolution)

    def _scaled(self, points: FloatArray) -> FloatArray:
        """Column and row (n, 2) in [cells]: cell [i, j] reaches from (j, i) to (j + 1, i + 1)."""
        return (points - self.origin) / self.resolution


@compiled
def nearest_square(
    solid: BoolArray, between_centres: SingleArray, x: float, y: float
) -> tuple[float, float, float]:
    """Return the distance of a point to the nearest solid cell, and x and y of the nearest spot of that cell.

    Cells are square. They are searched in rings around the point, beginning at the least distance that
    `between_centres` allows. All results are in [cells], x and y from the map's lower-left corner; these are
    NaN if no cell is solid.

    Args:
        solid: (h, w) True for solid cells.
        between_centres: (h, w) distance of each cell's centre to the nearest solid cell's centre, in [cells].
        x: x of the point, in [cells] from the map's lower-left corner.
        y: y of the point, in [cells] from the map's lower-left corner.
    """
    height, width = solid.shape
    column = min(max(math.floor(x), 0), width - 1)
    row = min(max(math.floor(y), 0), height - 1)
    best, best_x, best_y = np.inf, np.nan, np.nan
    ring = max(0, int(between_centres[row, column] / 1.41422) - 1)
    while ring <= max(height, width):
        # A cell of this ring is at least ring - 1 cells, and what the point lacks to its cell's side, away.
        inner = min(min(x - column, column + 1.0 - x), min(y - row, row + 1.0 - y))
        if ring - 1.0 + max(inner, 0.0) > best:
            break
        for r in range(max(row - ring, 0), min(row + ring, height - 1) + 1):
            step = 1 if abs(r - row) == ring else max(2 * ring, 1)
            for c in range(column - ring, column + ring + 1, step):
                if c < 0 or c >= width or not solid[r, c]:
                    continue
                near_x, near_y = min(max(x, float(c)), c + 1.0), min(max(y, float(r)), r + 1.0)
                away = math.hypot(near_x - x, near_y - y)
                if away < best:
                    best, best_x, best_y = away, near_x, near_y
        ring += 1
    return best, best_x, best_y


@compiled
def _distances(solid: BoolArray, between_centres: SingleArray, at: FloatArray) -> FloatArray:
    found = np.empty(len(at))
    for i in range(len(at)):
        found[i] = nearest_square(solid, between_centres, at[i, 0], at[i, 1])[0]
    return found
