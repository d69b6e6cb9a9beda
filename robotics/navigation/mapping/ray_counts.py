"""Counts of hits and passing beams in each cell of a grid, and the map that they make."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray, Int32Array
from handcart.robotics.numerics.compiled import compiled

from .scan_log import Keyframe

MARGIN_M = 0.5
"""Margin of the grid around all that was hit."""
MIN_HIT_SHARE = 0.25
"""Minimum share of an occupied cell's beams that end in it, because walls are also passed at flat angles."""
MIN_HITS = 2
MIN_PASSES = 2
MAX_CELLS = 100_000_000


class MapTooLarge(ValueError):
    """Error of a map that would have more cells than memory allows."""


class RayCounts(NamedTuple):
    """Numbers of lidar beams that ended in, and passed through, each cell of a map; row 0 has the
    lowest y.
    """

    hits: Int32Array
    """(h, w) beams that ended in each cell."""
    passes: Int32Array
    """(h, w) beams that passed each cell."""
    resolution: float
    """Side of a cell, in [m]."""
    origin: tuple[float, float]
    """Lower-left corner, in [m]."""

    @property
    def grid(self) -> GridMap:
        """Map of occupied, free and unknown cells that follows from how many beams ended in each cell or
        passed through it.
        """
        seen = self.hits + self.passes
        occupied = (self.hits >= MIN_HITS) & (self.hits >= MIN_HIT_SHARE * seen)
        free = ~occupied & (self.passes >= MIN_PASSES)
        return GridMap(occupied, ~occupied & ~free, self.resolution, *self.origin)


def count_rays(keyframes: Sequence[Keyframe], poses: Sequence[Pose2], resolution: float) -> RayCounts:
    """Count in each cell of a grid how many beams of keyframes ended in it or passed through it.

    The grid contains all points where beams ended.

    Args:
        keyframes: keyframes, each with its scan.
        poses: map_T_base of each keyframe.
        resolution: side of a cell, in [m].

    Raises:
        MapTooLarge: the grid would have more than `MAX_CELLS` cells.
    """
    hits = [pose.apply(frame.hits) for frame, pose in zip(keyframes, poses, strict=True)]
    everything = np.concatenate([*hits, np.array([pose[:2] for pose in poses])])
    low = np.floor((everything.min(axis=0) - MARGIN_M) / resolution) * resolution
    size = np.ceil((everything.max(axis=0) + MARGIN_M - low) / resolution).astype(np.int64)
    if size.prod() > MAX_CELLS:
        raise MapTooLarge(f"{size[0]} x {size[1]} cells of {resolution:g} m; allowed: {MAX_CELLS} cells")
    shape = int(size[1]), int(size[0])
    counts = np.zeros(shape, np.int32), np.zeros(shape, np.int32)
    for frame, pose, ends in zip(keyframes, poses, hits, strict=True):
        origin = (pose.apply(frame.origin[None])[0] - low) / resolution
        _cast(*counts, origin, (ends - low) / resolution, True)
        _cast(*counts, origin, (pose.apply(frame.open_ends) - low) / resolution, False)
    return RayCounts(*counts, resolution, (float(low[0]), float(low[1])))


@compiled
def _cast(hits: Int32Array, passes: Int32Array, origin: FloatArray, ends: FloatArray, is_hit: bool) -> None:
    """Count beams from an origin (2,) to ends (n, 2), in cells: Amanatides and Woo (1987)."""
    height, width = hits.shape
    for k in range(len(ends)):
        x, y = origin[0], origin[1]
        column, row = math.floor(x), math.floor(y)
        last_column, last_row = math.floor(ends[k, 0]), math.floor(ends[k, 1])
        dx, dy = ends[k, 0] - x, ends[k, 1] - y
        step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
        grow_x = abs(1.0 / dx) if dx != 0.0 else math.inf
        grow_y = abs(1.0 / dy) if dy != 0.0 else math.inf
        next_x = ((column + 1 - x) if dx > 0 else (x - column)) * grow_x if dx != 0.0 else math.inf
        next_y = ((row + 1 - y) if dy > 0 else (y - row)) * grow_y if dy != 0.0 else math.inf
        for _ in range(abs(last_column - column) + abs(last_row - row)):
            if 0 <= column < width and 0 <= row < height:
                passes[row, column] += 1
            if next_x < next_y:
                column += step_x
                next_x += grow_x
            else:
                row += step_y
                next_y += grow_y
        if is_hit and 0 <= last_column < width and 0 <= last_row < height:
            hits[last_row, last_column] += 1
