"""Map that a base draws of its surroundings while its pose on the given map is unknown."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.start_search import ScanBeams
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, Int32Array

CELL_M = 0.05
MARGIN_M = 1.0  # of map beyond what was seen
SURFACE_GAP_M = 0.4  # between neighbouring echoes that are one surface
MAX_FREE_M = 6.0  # of a beam along which ground counts as seen to be free
KEYFRAME_M, KEYFRAME_RAD = 0.5, math.radians(30.0)  # of motion after which a scan is added


class _View(NamedTuple):
    """A scan, in the local frame."""

    echoes: FloatArray
    """(n, 2) in [m]."""
    joined: BoolArray
    """(n,) True where an echo and the one after it are one surface."""
    outline: FloatArray
    """(m, 2) corners of the ground that was seen to be free, in [m]."""
    origin: FloatArray
    """(2,) of the sensor, in [m]."""


class LocalMap:
    """Map of the surroundings that is drawn from scans, at poses from odometry and matching of the scans.

    All poses are in a frame called `local`, whose pose on the robot's own map may be unknown.
    """

    def __init__(self) -> None:
        """Create an empty map."""
        self._views: list[_View] = []
        self._poses: list[Pose2] = []
        self._grid: GridMap | None = None
        self._field: LikelihoodField | None = None

    def is_due(self, pose: Pose2) -> bool:
        """Return whether a pose local_T_base is new, so that a scan from it should be added.

        A pose is new if it differs from those of all added scans by at least 0.5 m or 30 degrees.
        """
        return not any(
            pose.distance(seen) < KEYFRAME_M and pose.turn(seen) < KEYFRAME_RAD for seen in self._poses
        )

    def add(self, pose: Pose2, beams: ScanBeams) -> None:
        """Draw a scan, taken at the pose local_T_base, into the map."""
        self._views.append(_view(pose, beams))
        self._poses.append(pose)
        self._grid = self._field = None

    @property
    def grid(self) -> GridMap:
        """Map of the sensed surroundings: surfaces are occupied, ground that no beam crossed is unknown."""
        if self._grid is None:
            self._grid = _drawn(self._views)
        return self._grid

    @property
    def field(self) -> LikelihoodField:
        """Likelihood field of the map `grid`, with which scans are matched."""
        if self._field is None:
            self._field = LikelihoodField(self.grid, is_drawn=True)
        return self._field

    @property
    def echoes(self) -> FloatArray:
        """Points (n, 2) at which beams of all scans hit something, in the local frame, in [m]."""
        return np.vstack([np.empty((0, 2)), *(view.echoes for view in self._views)])

    @classmethod
    def of_echoes(cls, echoes: FloatArray, pose: Pose2) -> LocalMap:
        """Return a map that contains given surface points and no free ground.

        Args:
            echoes: (n, 2) points where beams met a surface, in the local frame, in [m].
            pose: local_T_base from which they were seen.
        """
        made = cls()
        none = np.zeros(len(echoes), dtype=np.bool_)
        here = np.array([pose.x, pose.y])
        made._views.append(_View(echoes, none, np.empty((0, 2)), here))
        return made


def _view(pose: Pose2, beams: ScanBeams) -> _View:
    hit = np.isfinite(beams.ranges)
    local = pose.apply(beams.points)
    steps = np.hypot(*np.diff(local, axis=0).T) if len(local) > 1 else np.empty(0)
    neighbours = np.diff(np.flatnonzero(hit)) == 1
    joined = np.append((steps < SURFACE_GAP_M) & neighbours, False)[: len(local)]
    known = ~np.isnan(beams.ranges)
    free = np.minimum(np.where(hit, beams.ranges, beams.reach), MAX_FREE_M)
    free = np.where(known, free, 0.0)
    rays = np.column_stack([np.cos(beams.angles), np.sin(beams.angles)])
    order = np.argsort(np.mod(beams.angles - beams.angles[0], 2.0 * math.pi), kind="stable")
    ends = beams.origin + free[:, None] * rays
    corners = ends[order]
    if float(np.ptp(beams.angles)) < 1.9 * math.pi:
        corners = np.vstack([corners, beams.origin])
    return _View(local, joined, pose.apply(corners), pose.apply(beams.origin[None])[0])


def _drawn(views: list[_View]) -> GridMap:
    every = [view.origin[None] for view in views]
    every += [part for view in views for part in (view.echoes, view.outline) if len(part)]
    points = np.vstack(every) if every else np.zeros((1, 2))
    low = np.floor((points.min(axis=0) - MARGIN_M) / CELL_M) * CELL_M
    width, height = (np.ceil((points.max(axis=0) + MARGIN_M - low) / CELL_M).astype(int) + 1).tolist()
    free, occupied = np.zeros((height, width), np.uint8), np.zeros((height, width), np.uint8)

    def cells(part: FloatArray) -> Int32Array:
        return np.asarray(np.floor((part - low) / CELL_M), dtype=np.int32)

    for view in views:
        if len(view.outline) > 2:
            cv2.fillPoly(free, [cells(view.outline)], 1)
    for view in views:
        at = cells(view.echoes)
        occupied[at[:, 1], at[:, 0]] = 1
        for i in np.flatnonzero(view.joined):
            cv2.line(occupied, at[i].tolist(), at[i + 1].tolist(), 1)
    solid = occupied.astype(np.bool_)
    return GridMap(solid, ~solid & (free == 0), CELL_M, float(low[0]), float(low[1]))
