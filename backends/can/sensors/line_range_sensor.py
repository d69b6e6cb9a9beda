"""A scanning range sensor on a serial port."""

from __future__ import annotations

import math
import time

import numpy as np

from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.can_sensor_spec import LineSource
from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.live.live_sensor import Clock
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

from .line_sensor import LineSensor


class LineRangeSensor(LineSensor, RangeSensor):
    """Lidar that sends lines `$RANGE`, each a scan with evenly spread beams, counter-clockwise."""

    KIND = "RANGE"

    def __init__(
        self, source: LineSource, spec: RangeSpec, base_T_sensor: Transform, clock: Clock = time.monotonic
    ) -> None:
        """Open the sensor's port.

        Args:
            source: port of the sensor.
            spec: how many beams a scan has, and between which angles.
            base_T_sensor: (4, 4) pose of the sensor's frame in the base frame.
            clock: gives the time in [s].

        Raises:
            NoSensor: the port cannot be opened.
        """
        super().__init__("the range sensor", source, clock)
        self._spec = spec
        yaw = math.atan2(base_T_sensor[1, 0], base_T_sensor[0, 0])
        self._mount = Pose2(float(base_T_sensor[0, 3]), float(base_T_sensor[1, 3]), yaw)
        self._angles = spec.angles()
        self._scan = Scan(self._angles, np.full(spec.beams, np.inf), self._mount)

    def scan(self) -> Scan:
        """Return the last scan that arrived; ranges beyond the lidar's reach are set to infinity.

        Raises:
            StaleSensor: no new scan has arrived in time.
        """
        self.check_fresh()
        return self._scan

    def _sound(self, values: FloatArray) -> bool:
        return len(values) == self._spec.beams

    def _taken(self, lines: list[FloatArray]) -> None:
        ranges = np.where(lines[-1] > self._spec.reach_m, np.inf, lines[-1])
        self._scan = Scan(self._angles.copy(), ranges, self._mount)
