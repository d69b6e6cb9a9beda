"""Rolling occupancy of what a lidar senses and no map shows (Moravec and Elfes, 1985, in whole numbers)."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, Int8Array, Int32Array, SingleArray
from handcart.robotics.numerics.compiled import compiled

from .grid_map import GridMap

HIT_SCORE = 3  # added to a cell in which a beam ends
PASS_SCORE = 1  # taken from a cell through which beams pass, once a scan
OCCUPIED_SCORE = 5  # from which a cell counts as occupied: two hits; a lone reading is noise
MAX_SCORE = 12  # so that what has left is cleared by eight scans
REACH_M = 6.0  # farther returns are ignored: beams are sparse and the heading's error shifts their ends


class ScanLayer:
    """Layer of sensed obstacles on a map, by scores of its cells; beams raise the cells in which they end.

    Beams lower the scores of cells through which they pass. Cells that no beam meets keep their scores;
    `forget` resets those that were not hit for some time.
    """

    def __init__(self, grid: GridMap, reach: float = REACH_M) -> None:
        """Create an empty layer.

        Args:
            grid: map whose cells are used.
            reach: maximum distance from the sensor of the beams that are used, in [m].
        """
        self._grid, self._reach = grid, reach
        self._scores = np.zeros(grid.occupied.shape, dtype=np.int8)
        self._hit_at = np.zeros(grid.occupied.shape, dtype=np.float32)
        self._stamps = np.zeros(grid.occupied.shape, dtype=np.int32)
        self._stamp = 0

    @property
    def occupied(self) -> BoolArray:
        """Mask (h, w) of the cells that count as obstacles, with a score of at least `OCCUPIED_SCORE`."""
        return np.asarray(self._scores >= OCCUPIED_SCORE)

    @property
    def points(self) -> FloatArray:
        """Centres (n, 2) of the occupied cells on the map, in [m]."""
        return self._grid.to_point(np.argwhere(self.occupied))

    def merged(self) -> GridMap:
        """Return a copy of the map, in which the cells of sensed obstacles are occupied, too."""
        occupied = self.occupied
        return self._grid._replace(
            occupied=self._grid.occupied | occupied, unknown=self._grid.unknown & ~occupied
        )

    def take(
        self,
        map_T_sensor: Pose2,
        angles: FloatArray,
        ranges: FloatArray,
        explained: BoolArray,
        time: float,
    ) -> None:
        """Update the scores of the cells by a scan.

        Args:
            map_T_sensor: pose of the sensor on the map.
            angles: (n,) angles of the beams in the sensor frame, in [rad].
            ranges: (n,) ranges in [m]; infinity for beams without an echo, NaN for those without a reading.
            explained: (n,) True for beams that end at an obstacle of the map; they raise no score.
            time: time of the scan, in [s].
        """
        grid = self._grid
        self._stamp += 1
        rays = angles + map_T_sensor.theta
        start = np.array([map_T_sensor.y - grid.origin_y, map_T_sensor.x - grid.origin_x]) / grid.resolution
        hits = np.isfinite(ranges) & (ranges <= self._reach)
        lengths = np.where(np.isnan(ranges), 0.0, np.minimum(ranges, self._reach)) / grid.resolution
        ends = start + lengths[:, None] * np.column_stack([np.sin(rays), np.cos(rays)])
        raises = hits & ~explained
        _take(self._scores, self._hit_at, self._stamps, self._stamp, start, ends, raises, time)

    def add(self, points: FloatArray, time: float) -> None:
        """Mark the cells of points (n, 2) on the map, in [m], as occupied at a time in [s]."""
        cells = self._grid.to_cell(points[self._grid.inside(points)])
        rows, columns = cells[:, 0], cells[:, 1]
        self._scores[rows, columns] = MAX_SCORE
        self._hit_at[rows, columns] = time

    def erase(self, discs: FloatArray) -> None:
        """Remove the sensed obstacles in discs (k, 3): x, y on the map and radius, in [m]."""
        cells = np.argwhere(self._scores > 0) if len(discs) else np.empty((0, 2), dtype=np.int64)
        if not len(cells):
            return
        off = self._grid.to_point(cells)[:, None] - discs[None, :, :2]
        inside = (np.hypot(off[..., 0], off[..., 1]) <= discs[None, :, 2]).any(axis=1)
        self._scores[tuple(cells[inside].T)] = 0

    def forget(self, before: float) -> bool:
        """Reset the scores of cells last hit by a beam before a time in [s]; return whether there were any
        such cells.
        """
        old = (self._scores > 0) & (self._hit_at < before)
        self._scores[old] = 0
        return bool(old.any())

    def cells(self) -> FloatArray:
        """Return the cells that obstacles may occupy, (n, 4): x, y on the map in [m], score, time of the last
        hit in [s].

        The score, above 0, rises with beams that end in the cell and falls with beams that pass through it.
        """
        found = np.argwhere(self._scores > 0)
        rows, columns = found.T
        return np.column_stack(
            [self._grid.to_point(found), self._scores[rows, columns], self._hit_at[rows, columns]]
        )

    def restore(self, cells: FloatArray) -> None:
        """Set the scores of the cells in rows (n, 4) that the method `cells` returned earlier; keep other
        cells.

        Rows are x, y on the map in [m], score, and time in [s]. They may come from a layer on another map of
        the same frame; cells outside this map are ignored.
        """
        inside = cells[self._grid.inside(cells[:, :2])] if len(cells) else cells
        rows, columns = self._grid.to_cell(inside[:, :2]).T
        self._scores[rows, columns] = np.clip(inside[:, 2], 0, MAX_SCORE)
        self._hit_at[rows, columns] = inside[:, 3]


@compiled
def _take(
    scores: Int8Array,
    hit_at: SingleArray,
    stamps: Int32Array,
    stamp: int,
    start: FloatArray,
    ends: FloatArray,
    raises: BoolArray,
    time: float,
) -> None:
    """Raise the cells at the ends of beams, then lower those between; positions are rows and columns.

    A cell changes once in a scan (`stamps`), and is not lowered if it or one of its eight neighbours is hit:
    a corner that fills little of its cell is passed more often than it is hit.
    """
    height, width = scores.shape
    for i in range(len(ends)):
        row, column = math.floor(ends[i, 0]), math.floor(ends[i, 1])
        if raises[i] and 0 <= row < height and 0 <= column < width and stamps[row, column] != stamp:
            stamps[row, column] = stamp
            scores[row, column] = min(scores[row, column] + HIT_SCORE, MAX_SCORE)
            hit_at[row, column] = time
    for i in range(len(ends)):
        row, column = math.floor(ends[i, 0]), math.floor(ends[i, 1])
        if raises[i] and 0 < row < height - 1 and 0 < column < width - 1:
            stamps[row - 1 : row + 2, column - 1 : column + 2] = stamp
    if not _has_scores(scores, start, ends):
        return  # as on most floors: there is nothing to lower
    for i in range(len(ends)):
        rows, columns = ends[i, 0] - start[0], ends[i, 1] - start[1]
        length = math.sqrt(rows * rows + columns * columns)
        steps = int(2.0 * length) - 1
        for k in range(steps):
            share = 0.5 * k / length
            row, column = math.floor(start[0] + share * rows), math.floor(start[1] + share * columns)
            if not (0 <= row < height and 0 <= column < width):
                break
            if scores[row, column] > 0 and stamps[row, column] != stamp:
                stamps[row, column] = stamp
                scores[row, column] -= PASS_SCORE


@compiled
def _has_scores(scores: Int8Array, start: FloatArray, ends: FloatArray) -> bool:
    """Return whether a cell has a score in the rectangle about the sensor and the ends of its beams."""
    low, high, left, right = start[0], start[0], start[1], start[1]
    for i in range(len(ends)):
        low, high = min(low, ends[i, 0]), max(high, ends[i, 0])
        left, right = min(left, ends[i, 1]), max(right, ends[i, 1])
    height, width = scores.shape
    first, last = max(0, math.floor(left)), min(width, math.floor(right) + 1)
    for row in range(max(0, math.floor(low)), min(height, math.floor(high) + 1)):
        highest = np.int8(0)
        for column in range(first, last):  # without a branch: many cells are compared at once
            highest = max(highest, scores[row, column])
        if highest > 0:
            return True
    return False
