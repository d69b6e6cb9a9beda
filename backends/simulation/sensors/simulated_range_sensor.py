"""What the range sensors of all simulated backends share."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.keyed_noise import keyed_normal
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform


class SimulatedRangeSensor(RangeSensor):
    """Beams all round, all at the same instant, with Gaussian noise; nothing is black, bright or oblique."""

    STATE: ClassVar[Kinds] = {"_now": int}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, spec: RangeSpec, base_T_sensor: Transform, seed: int) -> None:
        """`base_T_sensor` (4, 4) is where the URDF mounts it."""
        self._spec, self._seed = spec, seed
        yaw = math.atan2(base_T_sensor[1, 0], base_T_sensor[0, 0])
        self._mount = Pose2(float(base_T_sensor[0, 3]), float(base_T_sensor[1, 3]), yaw)
        self._angles = np.linspace(-np.pi, np.pi, spec.beams, endpoint=False)
        self._now = 0
        self._last: tuple[int, Scan] | None = None

    @abstractmethod
    def _cast(self) -> NDArray[np.float64]:
        """True ranges (n,) along the beams, in [m]; infinite, or beyond reach, where nothing is."""

    def scan(self) -> Scan:
        """See `RangeSensor`."""
        if self._last is None or self._last[0] != self._now:
            self._last = (self._now, self._noisy(self._cast(), self._now))
        return self._last[1]

    def advance(self, period: int) -> None:
        """A new period begins."""
        self._now = period

    def _noisy(self, true: NDArray[np.float64], period: int) -> Scan:
        """What is read of true ranges (n,) in a period, in [m]."""
        noise = keyed_normal(self._seed, "range sensor", period, len(self._angles))
        ranges = np.maximum(true + self._spec.sigma_mm / 1e3 * noise, 0.0)
        ranges[ranges > self._spec.reach_m] = np.inf
        return Scan(self._angles.copy(), ranges, self._mount)
