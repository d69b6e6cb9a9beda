"""The inertial measurement unit of a simulated robot outdoors."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from handcart.backends.description.sensor_specs import ImuSpec
from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .simulated_imu import SimulatedImu
from .simulated_sensor import SensorSite


class FieldImu(SimulatedImu):
    """Simulated IMU for open ground, with the errors of real gyros and accelerometers.

    The gyros have errors of scale, and a bias that decays while they warm up and drifts as a random walk. The
    accelerometers measure the base's acceleration along its path and in curves, with a bias, noise and, while
    the base moves, vibration.
    """

    STATE: ClassVar = {
        **SimulatedImu.STATE,
        "_walk": FloatArray,
        "_place": Pose2,
        "_speed": float,
        "_felt": FloatArray,
    }

    def __init__(self, spec: ImuSpec, scene: Scene, period: float, seed: int) -> None:
        super().__init__(spec, scene, period, seed)
        self._spec = spec
        scale, warm, felt = keyed(seed, "gyros' constants").standard_normal((3, 3))
        self._scale = 1.0 + spec.gyro_scale_percent / 100 * scale
        self._warm = np.radians(spec.warm_up_deg_s) * warm
        self._felt_bias = spec.accelerometer_bias_m_s2 * felt
        self._walk, self._place = np.zeros(3), scene.base
        self._speed, self._felt = 0.0, np.zeros(3)

    def _read_rates(self) -> FloatArray:
        noise = self._rate_sigma * keyed_normal(self._seed, "gyros", self._now, 3)
        warm = self._warm * math.exp(-self._now * self._period / self._spec.warm_up_s)
        bias = self._bias + warm + self._walk
        return np.asarray(self._scale * self._turned / self._period + bias + noise)

    def _read_accelerations(self) -> FloatArray:
        shaken = self._spec.vibration_m_s2 if self._speed != 0.0 else 0.0
        sigma = math.hypot(self._felt_sigma, shaken)
        noise = sigma * keyed_normal(self._seed, "accelerometers", self._now, 3)
        return np.asarray(self._turn.T @ self._carried() + self._felt + self._felt_bias + noise)

    def advance(self, period: int) -> None:
        """Update biases, turning rates and accelerations from the base's motion in the period just ended."""
        self._wander(period)
        now = self._scene.base
        if now == self._place and self._speed == 0.0:
            self._turned, self._felt, self._now = np.zeros(3), np.zeros(3), period
            return
        super().advance(period)
        moved, before = now.relative_to(self._place), self._speed
        stands = now == self._place  # exactly: differences of equal places needn't be zero
        self._speed = 0.0 if stands else math.copysign(math.hypot(moved.x, moved.y), moved.x) / self._period
        speeding = (self._speed - before) / self._period
        self._felt = np.array([speeding, self._speed * moved.theta / self._period, 0.0])
        self._place = now

    def _wander(self, period: int) -> None:
        """Advance the bias of the gyros by a period."""
        wander = np.radians(self._spec.rate_random_walk_deg_s_rt_s) * math.sqrt(self._period)
        self._walk = self._walk + wander * keyed_normal(self._seed, "gyros' walk", period, 3)


def imu_for(site: SensorSite[ImuSpec]) -> SimulatedImu:
    """Build the IMU of a simulation without physics from `site`, the parts of the simulation. It is a
    `FieldImu` on rough open ground, otherwise a `SimulatedImu`.
    """
    return (FieldImu if site.scene.open_ground else SimulatedImu).build(site)
