"""What a drive senses about the base: on all of a small map, on a window of a large one."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.map_window import window_around
from handcart.robotics.navigation.maps.scan_layer import OCCUPIED_SCORE, ScanLayer
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField
from handcart.robotics.numerics.arrays import FloatArray

LARGE_MAP_CELLS = 1_500_000  # from which a window about the base is used
MIN_HALF_M = 12.0  # of a window's side
MAX_OFF_M = 4.0  # from the middle of the window, from where it is moved
BEYOND_REACH_M = 1.0  # of the lidar, that the window reaches


class NearMap:
    """Map around the base, with distances to obstacles, and sensed obstacles that the map does not show.

    Of a large map, only a window that moves with the base is used. Sensed cells outside the window are
    stored, and used again when the window comes back.
    """

    def __init__(self, grid: GridMap, sensed: FloatArray, reach: float, pose: Pose2) -> None:
        """Begin with the cells that earlier drives sensed.

        Args:
            grid: the complete map.
            sensed: (n, 4) sensed cells: x, y on the map in [m], score, and time of the last hit in [s].
            reach: range of the lidar, in [m].
            pose: map_T_base.
        """
        self._map = grid
        self.half = max(MIN_HALF_M, reach + MAX_OFF_M + BEYOND_REACH_M)
        """Half of the side of the window, in [m]."""
        small = grid.occupied.size <= LARGE_MAP_CELLS
        self.is_whole = small or bool(max(grid.occupied.shape) * grid.resolution <= 2.0 * self.half)
        """True if the window is the complete map."""
        self._rows_beyond = np.empty((0, 4))
        self._centre = np.array(pose[:2])
        self._set_window(sensed)

    def _set_window(self, sensed: FloatArray) -> None:
        x, y = self._centre.tolist()
        window = self._map if self.is_whole else window_around(self._map, x, y, self.half)
        self.layer = ScanLayer(window)
        """Scores of the window's cells."""
        self.layer.restore(sensed)
        if not self.is_whole and len(sensed):
            self._rows_beyond = sensed[~window.inside(sensed[:, :2])]
        self.field = LikelihoodField(window)
        """Distances to what the map shows in the window."""

    def follow(self, pose: Pose2) -> None:
        """Centre the map's window on the base again if the base is over `MAX_OFF_M` from the window's middle.

        Args:
            pose: map_T_base.
        """
        if self.is_whole or np.hypot(*(self._centre - pose[:2])) <= MAX_OFF_M:
            return
        sensed = self.cells()
        self._centre, self._rows_beyond = np.array(pose[:2]), np.empty((0, 4))
        self._set_window(sensed)

    def cells(self) -> FloatArray:
        """Return all cells (n, 4) that the lidar sensed as occupied and the map shows as free.

        A row is x, y of the cell on the map in [m], a score that grows with each hit of a beam, and the time
        of the last hit in [s].
        """
        return np.vstack([self.layer.cells(), self._rows_beyond])

    def forget(self, before: float) -> bool:
        """Drop sensed cells whose last hit by a lidar beam is older than a time, and return whether any were
        dropped.

        Args:
            before: the time, in [s] of the robot's time.
        """
        kept = self._rows_beyond[self._rows_beyond[:, 3] >= before]
        dropped = len(kept) < len(self._rows_beyond)
        self._rows_beyond = kept
        return self.layer.forget(before) or dropped

    def all_points(self) -> FloatArray:
        """Return the centres (n, 2) of all cells sensed as occupied, on the map in [m]."""
        beyond = self._rows_beyond[self._rows_beyond[:, 2] >= OCCUPIED_SCORE, :2]
        return np.vstack([self.layer.points, beyond])
