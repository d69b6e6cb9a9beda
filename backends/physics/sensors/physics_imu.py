"""The inertial measurement unit of the robot in physics."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from handcart.backends.description.sensor_specs import ImuSpec
from handcart.backends.simulation.sensors.simulated_imu import SimulatedImu
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.numerics.arrays import FloatArray


class PhysicsImu(SimulatedImu):
    """Simulated IMU in a physics engine.

    Unlike in `SimulatedImu`, its accelerometers measure the base's acceleration too, as a mean over two
    control periods.
    """

    STATE: ClassVar = {**SimulatedImu.STATE, "_place": FloatArray, "_speed": FloatArray, "_sped": FloatArray}

    def __init__(self, spec: ImuSpec, scene: Scene, period: float, seed: int) -> None:
        super().__init__(spec, scene, period, seed)
        self._place = self._scene.world_T_base[:3, 3].copy()
        self._speed = np.zeros(3)
        self._sped = np.zeros(3)

    def advance(self, period: int) -> None:
        """Update the readings at the end of a period; `period` is its number."""
        super().advance(period)
        place = self._scene.world_T_base[:3, 3].copy()
        speed = (place - self._place) / self._period
        self._sped = (speed - self._speed) / self._period
        self._place, self._speed = place, speed

    def _carried(self) -> FloatArray:
        return np.asarray(super()._carried() + self._sped)
