"""Distances to the surfaces of a map (Thrun, Burgard and Fox, 2005, section 6.4).

They are read between cell centres by bilinear interpolation. A surface lies somewhere in its cell, on average
at the centre: measured from the cells' edges a pose comes out twice as wrong.

A beam shows the side of a wall that faces the sensor. A wall of two cells, as a wall that lies exactly on
cell borders is drawn, has a surface in both of them: measured to the nearer one, its distance is flat from
one centre to the other, and a scan fits anywhere between them. A thicker wall attracts points that are beyond
its middle to its back. So distances for scans are measured to the surfaces that face the sensor alone.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, Int32Array, SingleArray, Uint16Array
from handcart.robotics.numerics.compiled import compiled

STEPS_PER_CELL = 256  # in which distances are stored: two bytes each reach to 255 cells
BEAM_SECTOR_COUNT = 8  # of a beam's direction; the first is along x
SECTOR_TAN = math.tan(math.pi / BEAM_SECTOR_COUNT)
MAX_FACING_COSINE = 0.4  # between a normal and a sector's middle: 90 degrees and half a sector, and a little
NORMAL_CELLS = 1.5  # sigma by which a map is blurred for its normals


class FieldValues(NamedTuple):
    """Distances of points to the nearest surface of a map, from a likelihood field, and their slopes."""

    distances: FloatArray
    """Distances (n,) in [m] of the points to the nearest surface; inf outside the map."""
    slopes: FloatArray
    """Slopes (n, 2) of the distances along x and y of the map, without unit."""


class LikelihoodField:
    """Likelihood field of a map: tables of the distance of each place to the nearest surface, to match
    scans.
    """

    def __init__(self, grid: GridMap, is_drawn: bool = False) -> None:
        """Compute the field; takes roughly a millisecond for 100,000 cells.

        Args:
            grid: the map.
            is_drawn: True if cells are occupied where echoes were, so that several of them side by side are
                one surface with its noise, and no side of them is nearer to the truth.
        """
        self._is_drawn = is_drawn
        solid = grid.occupied.astype(np.uint8)
        inner = cv2.erode(solid, np.ones((3, 3), dtype=np.uint8), borderType=cv2.BORDER_REPLICATE)
        away = (solid == inner).astype(np.uint8)
        self.map = grid
        if away.all():
            self.distance = np.full(away.shape, np.inf, dtype=np.float32)
        else:
            cells = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            self.distance = (cells * grid.resolution).astype(np.float32)

    @cached_property
    def facing(self) -> Uint16Array:
        """Distances (8, h, w) of the cells to the nearest surface that faces the sensor.

        The first index k is that of the beam's direction on the map, k times 45 degrees. Distances are in
        steps of 1 / `STEPS_PER_CELL` cells, up to 255 cells. If the map was drawn from scans, the shape is
        (1, h, w), and distances are those to any surface.
        """
        if self._is_drawn:
            return _in_steps(self.distance / np.float32(self.map.resolution))[None]
        solid = self.map.occupied
        cells = solid.astype(np.float32)
        grey = cv2.GaussianBlur(cells, (0, 0), NORMAL_CELLS, borderType=cv2.BORDER_REPLICATE)
        x, y = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
        least = -MAX_FACING_COSINE * np.hypot(x, y)
        found = np.empty((BEAM_SECTOR_COUNT, *solid.shape), dtype=np.uint16)
        for sector in range(BEAM_SECTOR_COUNT):
            angle = 2.0 * math.pi * sector / BEAM_SECTOR_COUNT
            before = ~solid & (math.cos(angle) * x + math.sin(angle) * y >= least)
            beside = cv2.dilate(before.astype(np.uint8), np.ones((3, 3), dtype=np.uint8))
            found[sector] = _in_steps(_distances(solid & (beside > 0)))
        return found

    def read(self, points: FloatArray) -> FloatArray:
        """Return the distances (n,) of points to the nearest surface, in [m]; inf outside the map.

        Args:
            points: (n, 2) on the map, in [m].
        """
        return np.asarray(read_distance(self.distance, self._scaled(points)))

    def reading(self, points: FloatArray, sensor: tuple[float, float]) -> FieldValues:
        """Return the distances of points to the nearest surfaces that face a sensor, and the slopes of these
        distances.

        Args:
            points: (n, 2) on the map, in [m].
            sensor: x and y of the sensor on the map, in [m].
        """
        sectors = beam_sectors(points, sensor, len(self.facing))
        readings = read_field(self.facing, self.map.occupied, self._scaled(points), sectors)
        return FieldValues(readings[:, 0] * self.map.resolution, readings[:, 1:3])

    def fixed(self, points: FloatArray, pose: Pose2) -> FloatArray:
        """Return the points (m, 2) of a scan that are not near things that the map marks as movable.

        Args:
            points: (n, 2) in the base frame, in [m].
            pose: map_T_base.
        """
        movable = self.map.movable
        if movable is None or not len(points):
            return points
        origin = self.map.origin_x, self.map.origin_y
        near = marked_points(movable, pose.apply(points), origin, self.map.resolution)
        return np.ascontiguousarray(points[~near])

    def _scaled(self, points: FloatArray) -> FloatArray:
        """Return column and row (n, 2) in [cells], cell centres at whole numbers."""
        grid = self.map
        return (points - (grid.origin_x, grid.origin_y)) / grid.resolution - 0.5


def _distances(surface: BoolArray) -> SingleArray:
    """Return the distance (h, w) of each cell to the nearest surface cell, in [cells]; inf without one."""
    if not surface.any():
        return np.full(surface.shape, np.inf, dtype=np.float32)
    away = (~surface).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), dtype=np.float32)


def _in_steps(cells: NDArray[np.floating[Any]]) -> Uint16Array:
    """Return distances in cells as whole steps of 1 / `STEPS_PER_CELL`, as far as two bytes reach."""
    steps = np.minimum(cells * STEPS_PER_CELL + 0.5, np.iinfo(np.uint16).max)
    return np.asarray(steps, dtype=np.uint16)


@compiled
def marked_points(
    cells: BoolArray, points: FloatArray, origin: tuple[float, float], resolution: float
) -> BoolArray:
    """Return a mask (n,), True for points in cells of a map that are marked; False outside the map.

    Args:
        cells: (h, w) True for marked cells; row 0 has the lowest y.
        points: (n, 2) on the map, in [m].
        origin: x, y of the lower-left corner of cell [0, 0], in [m].
        resolution: side of a cell, in [m].
    """
    height, width = cells.shape
    out = np.zeros(len(points), dtype=np.bool_)
    for i in range(len(points)):
        column = math.floor((points[i, 0] - origin[0]) / resolution)
        row = math.floor((points[i, 1] - origin[1]) / resolution)
        if 0 <= column < width and 0 <= row < height:
            out[i] = cells[row, column]
    return out


@compiled
def beam_sectors(points: FloatArray, sensor: tuple[float, float], count: int) -> Int32Array:
    """Return the first index of `LikelihoodField.facing` for each of n points, (n,), as seen from a sensor.

    The index is k if the direction from the sensor to the point is nearest to k times 45 degrees.

    Args:
        points: (n, 2) end points of beams on the map, in [m].
        sensor: x and y of the sensor on the map, in [m].
        count: length of `facing`; 1 for a map drawn from scans, for which all indices are 0.
    """
    out = np.zeros(len(points), dtype=np.int32)
    if count == 1:
        return out
    for i in range(len(points)):
        x, y = points[i, 0] - sensor[0], points[i, 1] - sensor[1]
        if abs(y) < SECTOR_TAN * abs(x):
            out[i] = 0 if x > 0.0 else 4
        elif abs(x) < SECTOR_TAN * abs(y):
            out[i] = 2 if y > 0.0 else 6
        else:
            out[i] = (1 if y > 0.0 else 7) if x > 0.0 else (3 if y > 0.0 else 5)
    return out


@compiled
def read_distance(distance: SingleArray, at: FloatArray) -> FloatArray:
    """Return distances (n,) at points, in the unit of `distance`, interpolated bilinearly; infinity outside
    the map.

    Args:
        distance: (h, w) of each cell to the nearest surface, in any unit.
        at: (n, 2) column and row of the points; centres of cells are at whole numbers.
    """
    height, width = distance.shape
    out = np.empty(len(at))
    for i in range(len(at)):
        column, row = math.floor(at[i, 0]), math.floor(at[i, 1])
        if not (0 <= column < width - 1 and 0 <= row < height - 1):
            out[i] = np.inf
            continue
        u, v = at[i, 0] - column, at[i, 1] - row
        low = distance[row, column] * (1 - u) + distance[row, column + 1] * u
        high = distance[row + 1, column] * (1 - u) + distance[row + 1, column + 1] * u
        out[i] = low * (1 - v) + high * v
    return out


@compiled
def read_field(
    facing: Uint16Array,
    occupied: BoolArray,
    at: FloatArray,
    sectors: Int32Array,
) -> FloatArray:
    """Return for each point the distance to the nearest surface, the slopes of the distance, and whether the
    point is in a solid cell.

    Args:
        facing: (k, h, w) distances in steps of 1 / `STEPS_PER_CELL` cells, as `LikelihoodField.facing`.
        occupied: (h, w) cells of the map.
        at: (n, 2) column and row of points, cell centres at whole numbers.
        sectors: (n,) for each point, the sector of its beam's direction, which is the index along the first
            axis of `facing`.

    Returns:
        (n, 4): distance in [cells]; its derivatives along columns and rows, without unit; and 1 in a solid
            cell, otherwise 0. Outside the map, infinity and three zeros.
    """
    _, height, width = facing.shape
    out = np.empty((len(at), 4))
    for i in range(len(at)):
        column, row = math.floor(at[i, 0]), math.floor(at[i, 1])
        if not (0 <= column < width - 1 and 0 <= row < height - 1):
            # A whole row at once would take two seconds more to compile.
            out[i, 0], out[i, 1], out[i, 2], out[i, 3] = np.inf, 0.0, 0.0, 0.0
            continue
        u, v, k = at[i, 0] - column, at[i, 1] - row, sectors[i]
        a, b = facing[k, row, column] / STEPS_PER_CELL, facing[k, row, column + 1] / STEPS_PER_CELL
        c, d = facing[k, row + 1, column] / STEPS_PER_CELL, facing[k, row + 1, column + 1] / STEPS_PER_CELL
        out[i, 0] = (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v
        out[i, 1] = (b - a) * (1 - v) + (d - c) * v
        out[i, 2] = (c - a) * (1 - u) + (d - b) * u
        out[i, 3] = occupied[int(row + v + 0.5), int(column + u + 0.5)]
    return out
