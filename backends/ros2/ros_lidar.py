"""A lidar, by `sensor_msgs/LaserScan`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.capabilities.scan import Scan
from handcart.backends.description.sensor_specs import RangeSpec
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.navigation.scans.beam_angles import ranges_at

from .wire.topic_sensor import TopicSensor

MAX_ANGLE_DIFFERENCE_DEG = 0.5
MAX_COUNT_CHANGE = 0.03
"""Difference in the number of beams from that of the robot's file, as a share of it; many drivers deliver
what a turn had.
"""


class RosLidar(TopicSensor, RangeSensor):
    """Lidar whose raw scans are received from a ROS topic.

    Scans with decreasing angles are reversed, and so are those of a lidar that is mounted upside down. Scans
    with some beams more or less than the robot's file states are read at its angles.
    """

    KIND = "sensor_msgs/LaserScan"

    def fit(self, spec: RangeSpec, base_T_sensor: Transform, is_upside_down: bool = False) -> None:
        """Set the lidar's section of the robot's file, and its pose, before the first scan.

        Args:
            spec: section of the robot's file.
            base_T_sensor: (4, 4) pose of the sensor's frame in the base frame, upright.
            is_upside_down: True if the messages' frame is that frame, turned by 180 degrees about its x axis.
        """
        self._sign = -1.0 if is_upside_down else 1.0
        yaw = math.atan2(base_T_sensor[1, 0], base_T_sensor[0, 0])
        self._mount = Pose2(float(base_T_sensor[0, 3]), float(base_T_sensor[1, 3]), yaw)
        self._spec, self._angles = spec, spec.angles()

    @override
    def scan(self) -> Scan:
        """Return the last raw scan; raise `StaleSensor` if it is older than the robot's file allows."""
        self.check_fresh()
        return self._scan

    @override
    def _wrong(self, message: Any) -> str:
        count, beams = len(message.ranges), self._spec.beams
        if abs(count - beams) > MAX_COUNT_CHANGE * beams:
            return f"it has {len(message.ranges)} beams; the robot's file says {self._spec.beams}"
        if not math.isfinite(message.angle_min) or not math.isfinite(message.angle_increment):
            return "its angles are not finite"
        first, step = self._first_and_step(message)
        if step == 0.0:
            return "its angle_increment is 0"
        ends = first, first + step * (count - 1)
        allowed = MAX_ANGLE_DIFFERENCE_DEG + (0.0 if count == beams else math.degrees(1.5 * step))
        wanted = float(self._angles[0]), float(self._angles[-1])
        off = [math.degrees(math.remainder(a - b, 2.0 * math.pi)) for a, b in zip(ends, wanted, strict=True)]
        if max(map(abs, off)) > allowed:
            received, kept = _degrees(ends), _degrees(wanted)
            return f"its beams are at {received} deg; the robot's file says {kept} deg"
        return ""

    @override
    def _read(self, messages: list[Any]) -> None:
        scan = messages[-1]
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        ranges = ranges.copy() if self._sign * scan.angle_increment > 0.0 else ranges[::-1].copy()
        if len(ranges) != self._spec.beams:
            ranges = ranges_at(*self._first_and_step(scan), ranges, self._angles)
        self._scan = Scan(self._angles.copy(), ranges, self._mount)

    def _first_and_step(self, message: Any) -> tuple[float, float]:
        """Return the angle of the first beam, counter-clockwise, and the step to the next, in [rad]."""
        step = self._sign * message.angle_increment
        first = self._sign * message.angle_min
        return (first, step) if step >= 0.0 else (first + step * (len(message.ranges) - 1), -step)


def _degrees(ends: tuple[float, float]) -> str:
    return " to ".join(f"{math.degrees(end):.1f}" for end in ends)
