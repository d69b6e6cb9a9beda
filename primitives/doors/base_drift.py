"""Motion of the standing base while a hand pulls, by the lidar: no encoder shows tyres that creep."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.small_motion import drift, small_motions
from handcart.robotics.numerics.arrays import FloatArray

REFERENCE_PERIODS = 20
MIN_RECORDS = 10


class BaseDrift:
    """Recorder of measured points in the base frame, corrected for a slow drift of the base.

    The drift is estimated from lidar scans.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._lidar = robot.backend.get(RangeSensor)  # type: ignore[type-abstract]
        self._reference: FloatArray = np.empty(0)
        self._began = robot.time
        self._scans: list[Scan] = []
        self._times: list[float] = []
        self._points: list[FloatArray] = []

    def begin(self) -> Generator[None, None, None]:
        """Average some scans of the base at rest, as reference for its later drift; do nothing without a
        lidar.
        """
        if self._lidar is None:
            return
        ranges = []
        for _ in range(REFERENCE_PERIODS):
            ranges.append(self._lidar.scan().ranges)
            yield
        self._reference, self._began = np.asarray(np.mean(ranges, axis=0)), self._robot.time

    def add(self, point: FloatArray) -> None:
        """Record a point (3,), which was measured now in the base frame, in [m], to be corrected for the
        base's drift later.
        """
        self._points.append(point)
        self._times.append(self._robot.time - self._began)
        if self._lidar is not None:
            self._scans.append(self._lidar.scan())

    def points(self) -> FloatArray:
        """Return all recorded points (n, 3), in [m], in the base frame at the time when the last one was
        recorded.

        The base's motion from each record of a point to the last is estimated from the lidar scans at these
        times. Without a lidar, or if the scans are too few or do not match, the points are returned as
        recorded.
        """
        points, motions = np.array(self._points), self._motions()
        if motions is None:
            return points
        to_base = self._scans[0].base_T_sensor
        poses = [to_base.compose(Pose2(*motion)).compose(to_base.inverse()) for motion in motions.tolist()]
        last = poses[-1].inverse()
        flat = [
            last.compose(pose).apply(point[None, :2])[0] for pose, point in zip(poses, points, strict=True)
        ]
        return np.column_stack([np.array(flat), points[:, 2]])

    def _motions(self) -> FloatArray | None:
        if self._lidar is None or len(self._scans) < MIN_RECORDS:
            return None
        ranges = np.array([scan.ranges for scan in self._scans])
        motions = small_motions(self._scans[0].angles, self._reference, ranges)
        return None if motions is None else drift(np.array(self._times), motions, REFERENCE_PERIODS)
