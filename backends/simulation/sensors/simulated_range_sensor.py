"""Common base of the lidars of all simulated backends."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

from .range_faults import NO_FAULTS, RangeFaults
from .simulated_sensor import SimulatedSensor


class SimulatedRangeSensor(RangeSensor, SimulatedSensor):
    """Simulated lidar with Gaussian noise, and with faulty readings such as a real lidar's driver delivers.

    All beams are measured at one instant. Black surfaces and flat angles lose no readings. A reading below
    `range_min_m` is -infinity (REP 117). `errors` in the robot's file sets the shares of beams that read
    zero, NaN, -infinity or the robot's own body.
    """

    STATE: ClassVar[Kinds] = {"_now": int}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(
        self, spec: RangeSpec, base_T_sensor: Transform, seed: int, faults: RangeFaults = NO_FAULTS
    ) -> None:
        """Prepare a lidar.

        Args:
            spec: the lidar's section of the robot's file.
            base_T_sensor: (4, 4) pose of the sensor's frame in the base frame, by the URDF.
            seed: seed of the noise.
            faults: shares of faulty readings that the driver delivers.
        """
        self._spec, self._seed, self._faults = spec, seed, faults
        yaw = math.atan2(base_T_sensor[1, 0], base_T_sensor[0, 0])
        self._mount = Pose2(float(base_T_sensor[0, 3]), float(base_T_sensor[1, 3]), yaw)
        self._angles = spec.angles()
        self._now = 0
        self._last: tuple[int, Scan] | None = None

    @abstractmethod
    def _cast(self) -> FloatArray:
        """Return the true ranges (n,) along the beams, in [m]; infinite without an obstacle within reach."""

    @override
    def scan(self) -> Scan:
        if self._last is None or self._last[0] != self._now:
            self._last = (self._now, self._noisy(self._cast(), self._now))
        return self._last[1]

    def advance(self, period: int) -> None:
        """Begin a new period, in which the next request takes a new scan."""
        self._now = period

    def _noisy(self, true: FloatArray, period: int) -> Scan:
        """Return the scan of a period, with noise and faults, given the true ranges (n,) in [m]."""
        noise = keyed_normal(self._seed, "range sensor", period, len(self._angles))
        ranges = np.maximum(true + self._spec.sigma_mm / 1e3 * noise, 0.0)
        ranges[ranges > self._spec.reach_m] = np.inf
        ranges[ranges < self._spec.range_min_m] = -np.inf
        if self._faults.any:
            ranges = self._faults.spoil(ranges, keyed(self._seed, "range sensor faults", period))
        return Scan(self._angles.copy(), ranges, self._mount)
