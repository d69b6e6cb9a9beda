"""Motion that a robot with a polygonal footprint can make before it touches an obstacle."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from handcart.robotics.geometry.footprint import Footprint, polygon_distance
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.wall_cells import WallCells
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.numerics.compiled import compiled

from .way_guard import NO_STANDS, RETURN_NOISE_M, START_RETREAT_RATIO, HoldingObstacle

SENSED_CELL_M = 0.08  # from a cell's centre to a point of the scan that shows it
MIN_STEP_M = 0.002  # between two looks along a motion
LEAST_ROOM_M = 0.002  # that is kept along a wall, however near the robot has come to it
WALL_POINTS = 8  # points nearer than the margin, from which they count as a wall that it may drive along
SAME_ROOM_M = 1e-6  # by which room may shrink where the robot is too near to something


class _Stand(NamedTuple):
    """A pose at which the robot may be nearer to obstacles than elsewhere."""

    pose: Pose2
    room: tuple[float, float]
    """Distance from the footprint to obstacles of the map and of the scan, in [m]."""


class FootprintGuard:
    """Guard that checks whether the area that a polygonal footprint will sweep is free of obstacles.

    The obstacles are those of the map and of the lidar's scan. Where the lidar sees something at an occupied
    cell of the map, only the scan is used, because it does not depend on the pose and is more exact. Other
    occupied cells in the lidar's field of view are taken as points at their centres, cells outside it as
    complete squares. If an obstacle is nearer than the margin, the robot may still move along it or away from
    it, and return to the pose at which it began (`stand_at`).
    """

    def __init__(self, shape: Footprint, margin: float, grid: GridMap | None = None) -> None:
        """Guard a footprint.

        Args:
            shape: polygon of the footprint.
            margin: minimum distance from the footprint to any obstacle, in [m].
            grid: the map, if available: its occupied cells count as obstacles.
        """
        self._shape, self._margin = shape, margin
        self._cells = None if grid is None else WallCells(grid)
        self._stands: tuple[_Stand, ...] = ()

    def stand_at(self, pose: Pose2, scan: FloatArray) -> None:
        """Allow the robot to be as near to mapped and scanned obstacles as it is at a pose; forget all poses
        allowed earlier.

        Args:
            pose: map_T_base.
            scan: (n, 2) points in the base frame, in [m].
        """
        self._stands = (_Stand(pose, (self._map_room(pose), self._room(scan))),)

    def may_stand_at(self, pose: Pose2) -> None:
        """Accept one more pose map_T_base at which the robot may stand however near mapped obstacles are.

        Motions that come no nearer to mapped obstacles than this pose are then allowed.
        """
        self._stands += (_Stand(pose, (self._map_room(pose), math.inf)),)

    def free_motion(
        self,
        pose: Pose2,
        scan: FloatArray,
        length: float,
        turn: float,
        view: SensorView | None = None,
        direction: float = 0.0,
    ) -> HoldingObstacle | None:
        """Return the obstacle that a motion along an arc would touch; None if the motion is free.

        Args:
            pose: map_T_base.
            scan: (n, 2) points of the lidar in the base frame, in [m].
            length: length of the arc, in [m]; below zero backwards.
            turn: turn along the arc, in [rad], positive to the left.
            view: field of view of the lidar; None: all cells of the map count as out of the lidar's view.
            direction: direction of travel, relative to the base's heading, in [rad]. If it is not 0, the
                frame of `pose` and `scan` is the base frame turned by it.
        """
        shape = self._shape.turned(direction) if direction else self._shape
        view = view if view is None or not direction else view.turned(direction)
        mapped = self._mapped(pose, abs(length), view, scan)
        points = np.ascontiguousarray(np.vstack([mapped, scan]))
        if not len(points):
            return None
        corners = shape.corners
        motion, margin = np.array([length, turn]), self._margin
        found = _touched(
            corners, self._shape.radius, points, len(mapped), motion, margin, self._stood(pose, direction)
        )
        if found < 0:
            return None
        x, y = pose.apply(points[found : found + 1])[0].tolist()
        needed = math.hypot(*points[found]) - polygon_distance(corners, *points[found].tolist()) + margin
        shown: Literal["map", "scan"] = "map" if found < len(mapped) else "scan"
        return HoldingObstacle(shown, x, y, math.hypot(*points[found]), needed)

    def _mapped(
        self, pose: Pose2, length: float, view: SensorView | None, scan: FloatArray = NO_STANDS
    ) -> FloatArray:
        """Return (n, 2) points of the map that count, in the base frame, in [m]."""
        if self._cells is None:
            return np.empty((0, 2))
        reach = self._shape.radius + self._margin + length
        centres = pose.inverse().apply(self._cells.near((pose.x, pose.y), reach))
        seen = np.zeros(len(centres), dtype=np.bool_) if view is None else view.sees(centres)
        unexplained = centres[seen]
        if len(scan) and len(unexplained):
            unexplained = unexplained[_apart(unexplained, np.ascontiguousarray(scan), SENSED_CELL_M)]
        if seen.all():
            return unexplained
        return np.vstack([unexplained, self._cells.corners(centres[~seen], pose.theta)])

    def _room(self, points: FloatArray) -> float:
        return float(self._shape.distances(points).min()) if len(points) else math.inf

    def _map_room(self, pose: Pose2) -> float:
        return self._room(self._mapped(pose, 0.5, None))

    def _stood(self, pose: Pose2, direction: float) -> FloatArray:
        """Return (k, 5): x, y and heading of each allowed pose in the base frame, and the room there."""
        back = pose.inverse()
        way = Pose2(0.0, 0.0, direction)
        rows = [(*back.compose(stand.pose).compose(way), *stand.room) for stand in self._stands]
        return np.array(rows, dtype=np.float64).reshape(-1, 5)


class SensorView(NamedTuple):
    """Field of view of a lidar on a base: its position and the range of its beams' angles."""

    x: float
    """Position of the lidar in the base frame, x and y in [m]."""
    y: float
    start: float
    """Angle of the first beam in the base frame, in [rad]."""
    width: float
    """Angle from the first to the last beam, anticlockwise, in [rad]; 2 pi all around."""

    def turned(self, angle: float) -> SensorView:
        """Return the field of view in a frame with the same origin whose x axis points along `angle`, in
        [rad].
        """
        cos, sin = math.cos(angle), math.sin(angle)
        x, y = cos * self.x + sin * self.y, cos * self.y - sin * self.x
        return SensorView(x, y, self.start - angle, self.width)

    def sees(self, points: FloatArray) -> BoolArray:
        """Return a mask (n,), True for points in the lidar's field of view.

        Args:
            points: (n, 2) in the base frame, in [m].
        """
        angle = np.arctan2(points[:, 1] - self.y, points[:, 0] - self.x)
        return np.asarray(np.mod(angle - self.start, 2.0 * math.pi) <= self.width)


@compiled
def _apart(points: FloatArray, others: FloatArray, limit: float) -> BoolArray:
    """Return which points (n, 2) have no other (m, 2) within `limit` in [m] (n,)."""
    found = np.ones(len(points), dtype=np.bool_)
    for i in range(len(points)):
        for j in range(len(others)):
            if (points[i, 0] - others[j, 0]) ** 2 + (points[i, 1] - others[j, 1]) ** 2 < limit * limit:
                found[i] = False
                break
    return found


@compiled
def _touched(
    corners: FloatArray,
    radius: float,
    points: FloatArray,
    mapped: int,
    motion: FloatArray,
    margin: float,
    stood: FloatArray,
) -> int:
    """Return the index of the first point that comes too near along a motion; -1 if none does.

    The first `mapped` points are of the map, the others of the scan. `motion`: length and turn of an arc.
    Each point moves in the base frame no faster than the arc is long, so as much room as it has is skipped.
    """
    length, turn = motion[0], motion[1]
    count = len(points)
    rooms = np.empty(count)
    wall, near = margin, 0
    for i in range(count):
        rooms[i] = np.inf
        far = math.sqrt(points[i, 0] ** 2 + points[i, 1] ** 2)
        if far - radius - abs(length) < margin:
            rooms[i] = polygon_distance(corners, points[i, 0], points[i, 1])
            if rooms[i] < margin:
                wall, near = min(wall, rooms[i]), near + 1
    along = margin if near < WALL_POINTS else max(LEAST_ROOM_M, wall)
    best, first = np.inf, -1
    for i in range(count):
        kind = 0 if i < mapped else 1
        far = math.sqrt(points[i, 0] ** 2 + points[i, 1] ** 2)
        speed = abs(length) + abs(turn) * (far + abs(length))
        if rooms[i] > margin + speed or speed < 1e-9:
            continue
        least = min(along, rooms[i]) - SAME_ROOM_M
        at, room = 0.0, rooms[i]
        while at < 1.0:
            at = min(1.0, at + max(MIN_STEP_M, room - least) / speed)
            angle = turn * at
            if abs(turn) < 1e-6:
                x, y = length * at, 0.5 * length * at * angle
            else:
                x, y = length / turn * math.sin(angle), length / turn * (1.0 - math.cos(angle))
            dx, dy = points[i, 0] - x, points[i, 1] - y
            cos, sin = math.cos(angle), math.sin(angle)
            room = polygon_distance(corners, cos * dx + sin * dy, cos * dy - sin * dx)
            allowed = least
            for k in range(len(stood)):
                back = math.sqrt((x - stood[k, 0]) ** 2 + (y - stood[k, 1]) ** 2)
                off = angle - stood[k, 2]
                back += radius * abs(off - 2.0 * math.pi * np.round(off / (2.0 * math.pi)))
                allowed = min(allowed, stood[k, 3 + kind] - RETURN_NOISE_M + START_RETREAT_RATIO * back)
            if room < allowed - 1e-9:
                if at < best:
                    best, first = at, i
                break
    return first
