"""Which beams of a lidar should return, by the map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2

from .grid_map import GridMap


def expected_echoes(
    grid: GridMap, map_T_sensor: Pose2, angles: NDArray[np.float64], reach: float
) -> NDArray[np.bool_]:
    """Return which beams meet an occupied cell of the map within reach.

    Args:
        grid: the map. Unknown cells, and what lies beyond the map, hide nothing.
        map_T_sensor: of the lidar.
        angles: (n,) of the beams in the sensor frame, in [rad].
        reach: to which the beams are followed, in [m].

    Returns:
        (n,).
    """
    along = np.arange(grid.resolution, reach, grid.resolution)
    turned = angles + map_T_sensor.theta
    x = map_T_sensor.x + np.outer(np.cos(turned), along)
    y = map_T_sensor.y + np.outer(np.sin(turned), along)
    rows, columns = grid.to_cell(np.column_stack([x.ravel(), y.ravel()])).T
    height, width = grid.occupied.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    met = np.zeros(len(rows), np.bool_)
    met[inside] = grid.occupied[rows[inside], columns[inside]]
    return np.asarray(met.reshape(x.shape).any(axis=1))
