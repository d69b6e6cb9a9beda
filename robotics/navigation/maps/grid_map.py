"""Occupancy grids, and what the grey levels of a map picture mean to ROS (nav2's map_server)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal, NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray, Int8Array, IntArray

Mode = Literal["trinary", "scale", "raw"]
UNKNOWN_VALUE = -1
OCCUPIED_VALUE = 100
FREE_VALUE = 0
UNKNOWN_GREY = 205  # value that map_saver writes for unmeasured cells


class GridMap(NamedTuple):
    """Occupancy grid map with occupied, unknown and free cells; row 0 has the lowest y.

    A point is looked up in the cell that contains it.
    """

    occupied: BoolArray
    """(h, w), row by column."""
    unknown: BoolArray
    """(h, w), never where `occupied`."""
    resolution: float
    """Side of a cell, in [m]."""
    origin_x: float
    """Lower-left corner of cell [0, 0], in [m]."""
    origin_y: float
    movable: BoolArray | None = None
    """(h, w) cells near things that may have moved since the map was made; None without any."""

    @property
    def blocked(self) -> BoolArray:
        """Mask (h, w) of the cells that are occupied or unknown, where a robot must not be."""
        return self.occupied | self.unknown

    def to_cell(self, points: FloatArray) -> IntArray:
        """Return the cells (n, 2), row and column, in which points are; for points off the map they are out
        of range.

        Args:
            points: (n, 2) in the map frame, in [m].
        """
        scaled = (np.asarray(points, dtype=np.float64) - (self.origin_x, self.origin_y)) / self.resolution
        cells: IntArray = np.floor(scaled[:, ::-1]).astype(np.int64)
        return cells

    def to_point(self, cells: IntArray | FloatArray) -> FloatArray:
        """Return the centres (n, 2) of cells in the map frame, in [m].

        Args:
            cells: (n, 2) row and column; fractions are positions between cells.
        """
        corner = np.array([self.origin_x, self.origin_y])
        points: FloatArray = (np.asarray(cells)[:, ::-1] + 0.5) * self.resolution + corner
        return points

    def inside(self, points: FloatArray) -> BoolArray:
        """Return a mask (n,), True for points that lie on the map.

        Args:
            points: (n, 2) in the map frame, in [m].
        """
        cells = self.to_cell(points)
        within: BoolArray = np.all((cells >= 0) & (cells < self.occupied.shape), axis=1)
        return within

    def with_points(self, points: FloatArray, radius: float = 0.0) -> GridMap:
        """Return this map with each sensed point as an obstacle.

        The cell of each point becomes occupied, and all cells whose centre is within `radius` of that cell's
        centre. Points outside the map are ignored.

        Args:
            points: (n, 2) in the map frame, in [m].
            radius: radius around each point's cell that becomes occupied, in [m].
        """
        cells = self.to_cell(points[self.inside(points)] if len(points) else np.empty((0, 2)))
        if len(cells) == 0:
            return self
        away = np.ones(self.occupied.shape, dtype=np.uint8)
        away[cells[:, 0], cells[:, 1]] = 0
        distance = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        added = distance * self.resolution <= radius + 1e-6
        return self._replace(occupied=self.occupied | added, unknown=self.unknown & ~added)


def from_occupancy(values: Int8Array, resolution: float, origin: tuple[float, float]) -> GridMap:
    """Return a map from occupancies in percent: 100 is occupied, 0 free, others unknown.

    Args:
        values: (h, w) in percent, row 0 at the bottom.
        resolution: side of a cell, in [m].
        origin: lower-left corner in the map frame, in [m].
    """
    occupied = values == OCCUPIED_VALUE
    return GridMap(occupied, ~occupied & (values != FREE_VALUE), resolution, origin[0], origin[1])


def from_ros(
    image: ByteArray,
    resolution: float,
    origin: tuple[float, float],
    occupied_thresh: float,
    free_thresh: float,
    negate: bool = False,
) -> GridMap:
    """Return a map from a ROS map picture, with nav2's mode `trinary`: cells are occupied, free or unknown.

    Args:
        image: (h, w) grey, from 0 to 255, row 0 on top, as in the file.
        resolution: side of a cell, in [m].
        origin: lower-left corner of the picture in the map frame, in [m]; turned pictures are not read.
        occupied_thresh: occupancy from which on a cell is occupied, 0 to 1.
        free_thresh: occupancy up to which a cell is free, 0 to 1; between the two it is unknown.
        negate: True if dark means free.
    """
    values = ros_occupancy(image, "trinary", occupied_thresh, free_thresh, negate)
    return from_occupancy(values, resolution, origin)


def unknown_read_as_free(image: ByteArray, free_thresh: float, negate: bool = False) -> int:
    """Return how many cells of a ROS map picture are meant as unknown but are free by the given threshold.

    Unknown cells have grey 205.

    Args:
        image: (h, w) grey, from 0 to 255.
        free_thresh: occupancy up to which a cell is free, 0 to 1.
        negate: True if dark means free.
    """
    is_free = occupancy_of_levels(negate)[UNKNOWN_GREY] <= free_thresh
    return int(np.count_nonzero(image == UNKNOWN_GREY)) if is_free else 0


class FloorBox(NamedTuple):
    """Rectangle on the floor occupied by a box, with centre (`x`, `y`) and sides in [m], and yaw in [rad]."""

    x: float
    y: float
    yaw: float
    length: float
    """Side along its own x."""
    width: float
    """Side along its own y."""


def from_boxes(
    boxes: Iterable[tuple[float, float, float, float, float]],
    resolution: float,
    origin: tuple[float, float],
    size: tuple[float, float],
) -> GridMap:
    """Return a map on which every cell that a box overlaps is occupied and all others are free.

    A box overlaps a cell even if the cell's centre is outside the box. So the box's surface is inside an
    occupied cell, on average at its centre, where scan matching and planning assume surfaces.

    Args:
        boxes: centre x and y, yaw, length and width of each box, in [m] and [rad].
        resolution: side of a cell, in [m].
        origin: lower-left corner of the map, in [m].
        size: width along x and height along y of the map, in [m]; rounded up to whole cells.
    """
    shape = (math.ceil(size[1] / resolution - 1e-9), math.ceil(size[0] / resolution - 1e-9))
    occupied = np.zeros(shape, dtype=np.bool_)
    free = GridMap(occupied, np.zeros(shape, dtype=np.bool_), resolution, origin[0], origin[1])
    for box in boxes:
        _draw(free, FloorBox(*box))
    return free


def _draw(grid: GridMap, box: FloorBox) -> None:
    """Occupy the cells that the box overlaps: separating axes of two rectangles."""
    cos, sin = abs(math.cos(box.yaw)), abs(math.sin(box.yaw))
    reach = 0.5 * np.array([cos * box.length + sin * box.width, sin * box.length + cos * box.width])
    corners = np.array([[box.x, box.y]]) + np.array([[-1.0], [1.0]]) * reach
    first, last = grid.to_cell(corners)
    low, high = np.clip([first, last + 1], 0, grid.occupied.shape)
    rows, columns = np.mgrid[low[0] : high[0], low[1] : high[1]]
    centres = grid.to_point(np.column_stack([rows.ravel(), columns.ravel()]))
    local = Pose2(box.x, box.y, box.yaw).inverse().apply(centres)
    half = 0.5 * grid.resolution
    touch = np.abs(centres - (box.x, box.y)) < reach + half - 1e-9
    touch_turned = np.abs(local) < np.array([box.length, box.width]) / 2 + half * (cos + sin) - 1e-9
    overlap = np.all(touch & touch_turned, axis=1).reshape(rows.shape)
    grid.occupied[low[0] : high[0], low[1] : high[1]] |= overlap


def occupancy_of_levels(negate: bool) -> FloatArray:
    """Return the occupancy (256,), from 0 to 1, of each grey level of a map picture.

    Dark is occupied, or free if `negate` is True.
    """
    level = np.arange(256) / 255.0
    return level if negate else 1.0 - level


def ros_occupancy(
    image: ByteArray,
    mode: Mode,
    occupied_thresh: float,
    free_thresh: float,
    negate: bool = False,
    opaque: BoolArray | None = None,
) -> Int8Array:
    """Return the occupancy (h, w) of a map picture in percent, as the data of a ROS OccupancyGrid.

    Unknown cells are -1; row 0 is at the bottom.

    The modes are those of nav2_map_server/src/map_io.cpp. `trinary` gives 0, 100 or unknown. `scale` also
    gives values between, for occupancies between the thresholds. `raw` copies grey levels of 0 to 100; others
    are unknown.

    Args:
        image: (h, w) grey, from 0 to 255, row 0 on top, as in the file.
        mode: `trinary`, `scale` or `raw`.
        occupied_thresh: occupancy from which on a cell is occupied, 0 to 1.
        free_thresh: occupancy up to which a cell is free, 0 to 1.
        negate: True if dark means free.
        opaque: (h, w) True for opaque pixels; transparent ones are unknown, except in mode `raw`. None: all
            are opaque.
    """
    if mode == "raw":
        levels = np.arange(256)
        table = np.where(levels <= OCCUPIED_VALUE, levels, UNKNOWN_VALUE).astype(np.int8)
        opaque = None
    else:
        table = _table(occupancy_of_levels(negate), mode, occupied_thresh, free_thresh)
    values = table[image]
    if opaque is not None:
        values[~opaque] = UNKNOWN_VALUE
    return values[::-1]


def _table(level: FloatArray, mode: Mode, occupied_thresh: float, free_thresh: float) -> Int8Array:
    between = np.full(256, float(UNKNOWN_VALUE))
    if mode == "scale":
        between = np.floor(100.0 * (level - free_thresh) / (occupied_thresh - free_thresh) + 0.5)
    found = np.where(level >= occupied_thresh, OCCUPIED_VALUE, between)
    table: Int8Array = np.where(level <= free_thresh, FREE_VALUE, found).astype(np.int8)
    return table
