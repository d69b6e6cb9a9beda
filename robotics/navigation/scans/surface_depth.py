"""Error of a pose by the depth at which surfaces lie in their cells, where walls are seen from one side only.

A surface lies anywhere in its cell, up to half a cell before or behind the centre. How a map was drawn may
make that depth alike for all walls: those on cell borders are all at the front. Then the errors cancel where
a scan shows walls on both sides; where it shows walls on one side, the pose is off by the depth. Walls that
lie anywhere have depths of their own: the errors of two opposite ones cancel by chance alone.
"""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .likelihood_field import LikelihoodField

MAX_DEPTH_CELLS = 0.5
NEAR_CELLS = 2.0  # from a surface, within which a point counts as one on it
SCALE_CELLS = 1.0  # of the robust weights
SURFACE_SECTOR_COUNT = 8  # directions of surfaces, in each of which they count as one wall
MIN_INFORMATION = 1.0  # points: a direction with fewer is not determined by the scan at all


def depth_shifts(field: LikelihoodField, points: FloatArray, pose: Pose2) -> FloatArray:
    """Return how much a matched position would shift if the map's surfaces were not at the centres of their
    cells.

    The shifts are those for surfaces half a cell behind the centres, as seen from the sensor. For surfaces
    half a cell in front of the centres, the shifts are opposite.

    Args:
        field: likelihood field of the map.
        points: (n, 2) end points of the scan in the base frame, in [m].
        pose: map_T_base that fits the scan.

    Returns:
        (9, 2) shifts along x and y of the map, in [m]. Row 0 is for all surfaces together, row 1 + k only for
        surfaces whose normal towards the sensor has a direction on the map nearest to k times 45 degrees.
    """
    points = field.fixed(points, pose)
    if not len(points):
        return np.zeros((1 + SURFACE_SECTOR_COUNT, 2))
    on_map, resolution = pose.apply(points), field.map.resolution
    reading = field.reading(on_map, pose[:2])
    away, steep = on_map - pose[:2], np.hypot(*reading.slopes.T)
    used = (reading.distances < NEAR_CELLS * resolution) & (steep > 0.5)
    away, normals = away[used], reading.slopes[used] / steep[used, None]
    normals[np.sum(normals * away, axis=1) > 0.0] *= -1.0  # towards the sensor
    levers = normals[:, 1] * away[:, 0] - normals[:, 0] * away[:, 1]
    rows = np.column_stack([normals, levers])
    weights = 1.0 / (1.0 + (reading.distances[used] / (SCALE_CELLS * resolution)) ** 2) ** 2
    information = (rows * weights[:, None]).T @ rows + MIN_INFORMATION * np.eye(3)
    shifts = np.linalg.solve(information, rows.T * weights)[:2]
    facing = np.arctan2(normals[:, 1], normals[:, 0]) * (SURFACE_SECTOR_COUNT / (2.0 * np.pi))
    sectors = np.rint(facing).astype(np.int64) % SURFACE_SECTOR_COUNT
    walls = [np.bincount(sectors, shift, SURFACE_SECTOR_COUNT) for shift in shifts]
    total = np.column_stack([shifts.sum(axis=1), walls])
    return np.asarray(MAX_DEPTH_CELLS * resolution * total.T)
