"""The inertial measurement unit of a simulated robot."""

from __future__ import annotations

from typing import ClassVar, Self

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.imu import Imu
from handcart.backends.description.sensor_specs import ImuSpec
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.numerics.arrays import FloatArray

from .simulated_sensor import SensorSite, SimulatedSensor

GRAVITY_M_S2 = 9.81  # [m/s²]


class SimulatedImu(Imu, SimulatedSensor):
    """Simulated IMU with simple errors.

    The gyros have white noise and a constant bias; the accelerometers measure only gravity, with noise.
    """

    STATE: ClassVar[Kinds] = {"_turn": FloatArray, "_turned": FloatArray, "_now": int}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, spec: ImuSpec, scene: Scene, period: float, seed: int) -> None:
        self._scene, self._period, self._seed = scene, period, seed
        self._rate_sigma = np.radians(spec.angle_random_walk_deg_rt_s) / np.sqrt(period)
        self._bias = np.radians(spec.gyro_bias_deg_s) * keyed(seed, "gyro bias").standard_normal(3)
        self._felt_sigma = spec.accelerometer_sigma_m_s2
        self._turn = scene.world_T_base[:3, :3]
        self._turned, self._now = np.zeros(3), 0
        self._rates: tuple[int, FloatArray, FloatArray] | None = None
        self._accelerations: tuple[int, FloatArray, FloatArray] | None = None

    @classmethod
    @override
    def build(cls, site: SensorSite[ImuSpec]) -> Self:
        return cls(site.spec, site.scene, site.period, site.seed)

    @override
    def rates(self) -> FloatArray:
        last = self._rates
        if last is None or last[0] != self._now or last[1] is not self._turned:
            last = self._rates = (self._now, self._turned, self._read_rates())
        return last[2].copy()

    @override
    def accelerations(self) -> FloatArray:
        last = self._accelerations
        if last is None or last[0] != self._now or last[1] is not self._turn:
            last = self._accelerations = (self._now, self._turn, self._read_accelerations())
        return last[2].copy()

    def _read_rates(self) -> FloatArray:
        noise = self._rate_sigma * keyed_normal(self._seed, "gyros", self._now, 3)
        return np.asarray(self._turned / self._period + self._bias + noise)

    def _read_accelerations(self) -> FloatArray:
        noise = self._felt_sigma * keyed_normal(self._seed, "accelerometers", self._now, 3)
        return np.asarray(self._turn.T @ self._carried() + noise)

    def advance(self, period: int) -> None:
        """Update the readings from the robot's rotation in the period just ended."""
        turn = self._scene.world_T_base[:3, :3]
        stands = turn.tobytes() == self._turn.tobytes()
        self._turned = np.zeros(3) if stands else pin.log3(self._turn.T @ turn)
        self._turn, self._now = turn, period

    def _carried(self) -> FloatArray:
        """Return the specific force (3,) in the world frame, in [m/s²]: the robot's acceleration less that of
        gravity, so +9.81 along z at rest.
        """
        return np.array([0.0, 0.0, GRAVITY_M_S2])
