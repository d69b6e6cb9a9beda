"""Keyframes of a drive: a map that grows while the base moves."""

from __future__ import annotations

import numpy as np

from handcart.backends.robot.localization.lidar import Lidar
from handcart.backends.robot.localization.localizations import odometry_errors, range_noise
from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Measured, NeedsPerson
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.exploring.growing_map import GrowingMap
from handcart.robotics.navigation.mapping.scan_log import (
    KEYFRAME_TRAVEL_M,
    KEYFRAME_TURN_RAD,
    Keyframe,
    keyframe_of,
)
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.odometry.holonomic_odometry import odometry_of
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

STALE_TRAVEL_M = 0.3  # of the wheels, in which a lidar repeats its scan: it does not measure any more


class ScanCollector:
    """Collector of scans for a map that grows during a drive.

    Whenever the base has moved `KEYFRAME_TRAVEL_M` or turned `KEYFRAME_TURN_RAD`, the scan becomes a keyframe
    of the map.
    """

    def __init__(self, robot: Robot, lidar: Lidar, known: GridMap | None) -> None:
        """Begin with the scan of a robot at rest, on a given map if there is one."""
        self._lidar, self._travel = lidar, robot.localization.travel
        self._wheels = odometry_of(
            Pose2(0.0, 0.0, 0.0), robot.spec.drive.tread_m, odometry_errors(robot.spec), None
        )
        self.times = [robot.time]
        """Time of each keyframe, in [s]."""
        self._ranges, self._fresh_at = np.empty(0), 0.0
        self.rolled = 0.0
        """Distance that the wheels have rolled, in [m]."""
        self.map = GrowingMap(self._keyframe(0), robot.pose, known, range_noise(robot.spec))
        self._waiting = list[Keyframe]()
        self.is_busy = False
        """True while the map is used elsewhere: keyframes wait."""

    @property
    def odometry(self) -> Pose2:
        """Pose odom_T_base of the base by wheel odometry alone, since the start of the collection."""
        return self._wheels.pose

    @property
    def pose(self) -> Pose2:
        """Pose map_T_base: the pose at the last keyframe, plus the motion by wheel odometry since then."""
        return self.map.pose_of(self.odometry)

    def take(self, robot: Robot) -> None:
        """Update the wheel odometry, and keep this period's scan as a keyframe if one is due.

        A keyframe is due once the base has moved `KEYFRAME_TRAVEL_M` or turned `KEYFRAME_TURN_RAD` since the
        last keyframe.

        Raises:
            NeedsPerson: the lidar repeats its scan although the wheels roll.
        """
        travel, last = robot.localization.travel, self._travel
        moved = travel.left - last.left, travel.right - last.right, travel.sideways - last.sideways
        self._travel = travel
        self._wheels.predict(*moved)
        self.rolled += max(abs(0.5 * (moved[0] + moved[1])), abs(moved[2]))
        ranges = self._lidar.scan().ranges
        if not np.array_equal(ranges, self._ranges):
            self._ranges, self._fresh_at = ranges.copy(), self.rolled
        stale = self.rolled - self._fresh_at
        if stale > STALE_TRAVEL_M:
            words = "the lidar repeats its scan although the wheels roll"
            raise NeedsPerson(
                words,
                Measured("RangeSensor", "way without a new scan", stale, STALE_TRAVEL_M, "m"),
                cause=causes.SENSOR_FAULT,
            )
        last_frame = self._waiting[-1] if self._waiting else self.map.last
        if stale == 0.0 and _is_apart(last_frame, self.odometry) and not self._lidar.silence:
            self.times.append(robot.time)
            self._waiting.append(self._keyframe(len(self.times) - 1))
        self.flush()

    def flush(self) -> None:
        """Add all keyframes that were not yet added to the map, unless another computation uses the map
        (`is_busy`).
        """
        while self._waiting and not self.is_busy:
            self.map.add(self._waiting.pop(0))

    def add_here(self, robot: Robot) -> None:
        """Keep this period's scan as a keyframe of the map, even if the base has hardly moved since the last
        keyframe.
        """
        self.times.append(robot.time)
        self._waiting.append(self._keyframe(len(self.times) - 1))
        self.flush()

    def found_at(self, pose: Pose2) -> None:
        """Set the pose of the base to a measured one; from then on, wheel odometry is added to it.

        Args:
            pose: measured pose of the base on the growing map, start_T_base.
        """
        self.map.carry_on_from(self._keyframe(-1).odometry, pose)

    def look(self) -> Keyframe:
        """Return this period's scan as a keyframe, without adding it to the map."""
        return self._keyframe(-1)

    def _keyframe(self, number: int) -> Keyframe:
        scan, reach = self._lidar.scan(), self._lidar.spec.reach_m
        return keyframe_of(
            number, self.odometry, (scan.angles, _known(scan.ranges, scan.blind())), scan.base_T_sensor, reach
        )


def _known(ranges: FloatArray, blind: BoolArray) -> FloatArray:
    return np.where(blind, np.nan, ranges) if len(blind) else ranges


def _is_apart(frame: Keyframe, odometry: Pose2) -> bool:
    far = odometry.distance(frame.odometry) >= KEYFRAME_TRAVEL_M
    return far or odometry.turn(frame.odometry) >= KEYFRAME_TURN_RAD
