"""Distance that a round robot can move before it touches an obstacle of a map or a scan."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.clearances import Clearances, nearest_square
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled, compiled_for

# of each metre that it moved, by which it must be farther from an obstacle that was too near at the start
START_RETREAT_RATIO = 0.2
MIN_RETREAT_RATIO = 0.02  # likewise of each metre driven where it is too near by now: all but along it
RETURN_NOISE_M = 0.015  # [m] by which a clearance measured at the start may be smaller on return
MIN_STEP_M = 0.003  # [m] at least between two looks along the way
NO_STANDS = np.empty((0, 2))


class HoldingObstacle(NamedTuple):
    """Obstacle that prevents a robot from moving on, with its position, its distance and the distance
    needed.
    """

    shown_by: Literal["map", "scan", "contact", "unseen"]
    """Source of the obstacle; contact: the base ran into it; unseen: the lidar does not see the ground
    there.
    """
    x: float
    """Position of the obstacle on the map, x and y in [m]."""
    y: float
    room: float
    """Distance from the robot's centre to the obstacle, at the present pose, in [m]."""
    needed: float
    """Distance from the robot's centre that the obstacle should have, in [m]."""

    @property
    def words(self) -> str:
        """Text for messages that says where the obstacle is and by what it was noticed."""
        if self.shown_by == "unseen":
            there = f"the lidar does not see the ground at ({self.x:.2f}, {self.y:.2f}) m"
            return f"{there}, and the base did not just drive there"
        there = f"the {self.shown_by} shows something at ({self.x:.2f}, {self.y:.2f}) m"
        if self.shown_by == "contact":
            there = f"it ran into something at ({self.x:.2f}, {self.y:.2f}) m before"
        return f"{there}, {self.room:.2f} m from its middle, needed: {self.needed:.2f} m"


class _Stand(NamedTuple):
    """A pose at which the robot may be nearer to obstacles than elsewhere."""

    pose: Pose2
    room: tuple[float, float]
    """Distance from the robot's centre to obstacles of the map and of the scan, in [m]."""


class WayGuard:
    """Guard that checks whether the area that a disc-shaped robot will sweep is free of obstacles.

    The obstacles are those of the map and of the lidar's scan. If an obstacle is nearer to the disc's centre
    than the minimum distance (`needed`), only motion away from it is allowed, and the return to the pose at
    which the robot began (`stand_at`).
    """

    def __init__(self, needed: float, grid: GridMap | None = None) -> None:
        """Guard a disc.

        Args:
            needed: minimum distance from the disc's centre to any obstacle, in [m].
            grid: the map, if available: its occupied cells count as obstacles.
        """
        self._needed = needed
        nothing = np.zeros((1, 1), dtype=np.bool_)
        self._map = Clearances(GridMap(nothing, nothing, 1.0, 0.0, 0.0) if grid is None else grid)
        self._stands: tuple[_Stand, ...] = ()

    def stand_at(self, pose: Pose2, scan: FloatArray) -> None:
        """Allow the robot to be as near to mapped and scanned obstacles as it is at a pose; forget all poses
        allowed earlier.

        Args:
            pose: map_T_base.
            scan: (n, 2) points in the base frame, in [m].
        """
        scanned = float(np.hypot(*scan.T).min()) if len(scan) else math.inf
        self._stands = (_Stand(pose, (self._map.nearest(pose[:2]).distance, scanned)),)

    def may_stand_at(self, pose: Pose2) -> None:
        """Allow the robot to be at one more pose, map_T_base, however near mapped obstacles are there."""
        self._stands += (_Stand(pose, (self._map.nearest(pose[:2]).distance, math.inf)),)

    def free_way(
        self, pose: Pose2, scan: FloatArray, curvature: float, length: float
    ) -> tuple[float, HoldingObstacle | None]:
        """Return how much of an arc is free, in [m], and the obstacle that ends it; None if all is free.

        The free length has the sign of `length`.

        Args:
            pose: map_T_base.
            scan: (n, 2) points of the lidar in the base frame, in [m].
            curvature: curvature of the arc, in [1/m], positive to the left.
            length: length of the arc, in [m]; below zero backwards.
        """
        chart = self._map
        cell = np.array([*((np.array(pose[:2]) - chart.origin) / chart.resolution), chart.resolution])
        free, ended_by = _free_way(
            chart.solid,
            chart.between_centres,
            np.array([*cell, pose.theta]),
            scan,
            np.array([curvature, length]),
            self._needed,
            self._stood(pose),
        )
        return free, None if ended_by == 0 else self._held(pose, scan, ended_by == 1, curvature, free)

    def _stood(self, pose: Pose2) -> FloatArray:
        """Return (k, 4): x and y of each allowed pose in the base frame, and the room of map and scan
        there.
        """
        back = pose.inverse()
        rows = [(*back.compose(stand.pose)[:2], *stand.room) for stand in self._stands]
        return np.array(rows, dtype=np.float64).reshape(-1, 4)

    def _held(
        self, pose: Pose2, scan: FloatArray, by_map: bool, curvature: float, along: float
    ) -> HoldingObstacle:
        there = pose.compose(Pose2(*_on_arc(curvature, along), 0.0))
        if by_map:
            x, y = self._map.nearest(there[:2]).point.tolist()
        else:
            points = pose.apply(scan)
            x, y = points[np.argmin(np.hypot(*(points - there[:2]).T))].tolist()
        return HoldingObstacle(
            "map" if by_map else "scan", x, y, math.hypot(x - pose.x, y - pose.y), self._needed
        )


@compiled
def _on_arc(curvature: float, along: float) -> tuple[float, float]:
    turn = curvature * along
    if abs(turn) < 1e-6:
        return along, 0.5 * turn * along
    return math.sin(turn) / curvature, (1.0 - math.cos(turn)) / curvature


@compiled
def _rooms(
    solid: BoolArray,
    between_centres: SingleArray,
    at: FloatArray,
    scan: FloatArray,
    x: float,
    y: float,
    most: float,
) -> tuple[float, float]:
    """Return the distances from (x, y) to obstacles of the map and of the scan, in [m]; at most `most`.

    (x, y) is in the base frame. `at`: the base's column and row, the side of a cell in [m], and the base's
    heading in [rad].
    """
    cos, sin, resolution = math.cos(at[3]), math.sin(at[3]), at[2]
    column, row = at[0] + (cos * x - sin * y) / resolution, at[1] + (sin * x + cos * y) / resolution
    on_map = most
    c = min(max(math.floor(column), 0), solid.shape[1] - 1)
    r = min(max(math.floor(row), 0), solid.shape[0] - 1)
    off_map = math.hypot(column - c - 0.5, row - r - 0.5)
    if (between_centres[r, c] > 0.0 or solid[r, c]) and (
        between_centres[r, c] - off_map - 0.71 < most / resolution
    ):
        on_map = min(most, resolution * nearest_square(solid, between_centres, column, row)[0])
    scanned = most * most
    for i in range(len(scan)):
        scanned = min(scanned, (scan[i, 0] - x) ** 2 + (scan[i, 1] - y) ** 2)
    return on_map, math.sqrt(scanned)


@compiled_for("(b1[:,::1], f4[:,::1], f8[::1], f8[:,::1], f8[::1], f8, f8[:,::1])")
def _free_way(
    solid: BoolArray,
    between_centres: SingleArray,
    at: FloatArray,
    scan: FloatArray,
    way: FloatArray,
    needed: float,
    stood: FloatArray,
) -> tuple[float, int]:
    """Length of the arc `way` (curvature, length) that is free, with its sign, and what ends it: 0 nothing, 1
    the map, 2 the scan.

    Distances change by no more than the way driven, so a part as long as the room left is free.
    """
    size, sign = abs(way[1]), math.copysign(1.0, way[1])
    most = needed + 1.3 * size + MIN_STEP_M
    here = _rooms(solid, between_centres, at, scan, 0.0, 0.0, most)
    room, along = here, 0.0
    while True:
        x, y = _on_arc(way[0], sign * along)
        if along > 0.0:
            room = _rooms(solid, between_centres, at, scan, x, y, most)
        spare = np.inf
        for i in range(2):
            least = min(needed, here[i] + MIN_RETREAT_RATIO * along) if here[i] < needed else needed
            for k in range(len(stood)):
                away = math.hypot(x - stood[k, 0], y - stood[k, 1])
                least = min(least, stood[k, 2 + i] - RETURN_NOISE_M + START_RETREAT_RATIO * away)
            if room[i] < least - 1e-9:
                return sign * max(0.0, along - MIN_STEP_M), 1 + i
            spare = min(spare, room[i] - least)
        if along >= size:
            return way[1], 0
        along = min(size, along + max(MIN_STEP_M, spare / (1.0 + START_RETREAT_RATIO)))
