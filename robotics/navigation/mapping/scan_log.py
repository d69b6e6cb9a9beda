"""Recorded scans with the odometry at each of them, and the keyframes among them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .scan_surface import Surface, fit_surface

KEYFRAME_TRAVEL_M = 0.3
KEYFRAME_TURN_RAD = 0.2


class ScanLog(NamedTuple):
    """Log of a drive, with scans of one lidar in order of time, and the odometry at the time of each scan."""

    times: FloatArray
    """(n,) in [s], increasing."""
    odometry: FloatArray
    """(n, 3) odom_T_base: x, y in [m], heading in [rad]."""
    angles: FloatArray
    """Of the beams in the sensor frame, in [rad]: (b,) if all scans have the same ones, otherwise (n, b)."""
    ranges: FarArray
    """(n, b) in [m]; infinity where nothing is within the reach, NaN where nothing is known."""
    mount: Pose2
    """base_T_sensor."""
    reach: float
    """Maximum range of the lidar, in [m]."""
    notes: tuple[str, ...] = ()
    """Messages about tolerable faults of the log."""

    @property
    def distance(self) -> float:
        """Length of the travelled path by odometry, in [m]."""
        return float(np.hypot(*np.diff(self.odometry[:, :2], axis=0).T).sum())


class Keyframe(NamedTuple):
    """Scan from which a map is built, with the odometry's pose when it was taken; all points are in the base
    frame at that time.
    """

    row: int
    """Row of the log."""
    odometry: Pose2
    """odom_T_base."""
    surface: Surface
    """Flat surfaces, to match."""
    hits: FloatArray
    """(n, 2) where beams ended, in [m]."""
    open_ends: FloatArray
    """(m, 2) ends of the beams on which nothing is within the reach, in [m]."""
    origin: FloatArray
    """(2,) position of the sensor, in [m]."""


def keyframe_rows(log: ScanLog) -> list[int]:
    """Return the log's rows that are keyframes of a map, the first and last included.

    Successive keyframes are at least `KEYFRAME_TRAVEL_M` or `KEYFRAME_TURN_RAD` of odometry apart.
    """
    rows, last = [0], Pose2(*log.odometry[0])
    for row, pose in enumerate(map(Pose2._make, log.odometry.tolist())):
        if pose.distance(last) >= KEYFRAME_TRAVEL_M or pose.turn(last) >= KEYFRAME_TURN_RAD:
            rows.append(row)
            last = pose
    if rows[-1] != len(log.times) - 1 and Pose2(*log.odometry[-1]) != last:
        rows.append(len(log.times) - 1)
    return rows


def keyframe(log: ScanLog, row: int) -> Keyframe:
    """Return scan and odometry of one row of a log as a keyframe, a node of the map's pose graph."""
    odometry = Pose2(*log.odometry[row])
    angles = log.angles if log.angles.ndim == 1 else log.angles[row]
    return keyframe_of(row, odometry, (angles, log.ranges[row]), log.mount, log.reach)


def keyframe_of(
    row: int, odometry: Pose2, beams: tuple[FloatArray, FloatArray], mount: Pose2, reach: float
) -> Keyframe:
    """Return a keyframe made of a scan and the odometry at its time.

    Args:
        row: row of the scan in the log.
        odometry: odom_T_base.
        beams: angles (b,) in the sensor frame in [rad], and ranges (b,) in [m], infinity for a beam without
            an obstacle within the reach, NaN for an invalid beam.
        mount: base_T_sensor.
        reach: maximum range, in [m].
    """
    angles, ranges = beams
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    hit, is_open = np.isfinite(ranges), np.isinf(ranges)
    hits = mount.apply(ranges[hit, None] * rays[hit])
    open_ends = mount.apply(reach * rays[is_open]) if math.isfinite(reach) else np.empty((0, 2))
    origin = np.array([mount.x, mount.y])
    return Keyframe(row, odometry, fit_surface(hits, origin), hits, open_ends, origin)
