"""The inertial measurement unit of a robot that rides over rough ground in physics."""

from __future__ import annotations

import numpy as np

from handcart.backends.description.sensor_specs import ImuSpec
from handcart.backends.simulation.sensors.field_imu import FieldImu
from handcart.backends.simulation.sensors.simulated_imu import SimulatedImu
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite

from .physics_imu import PhysicsImu

REST_SPEED_M_S = 2e-3  # [m/s]: a slower base is at rest


class PhysicsFieldImu(FieldImu):
    """Simulated IMU on rough ground (`FieldImu`) for physics engines.

    In an engine a base is never completely at rest, so speeds below 2 mm/s count as rest.
    """

    def advance(self, period: int) -> None:
        """Update the readings at the end of a period; `period` is its number."""
        self._wander(period)
        SimulatedImu.advance(self, period)
        now, before = self._scene.base, self._speed
        moved, self._place = now.relative_to(self._place), now
        speed = moved.x / self._period
        self._speed = speed if abs(speed) > REST_SPEED_M_S else 0.0
        speeding = (self._speed - before) / self._period
        self._felt = np.array([speeding, self._speed * moved.theta / self._period, 0.0])


def physics_imu_for(site: SensorSite[ImuSpec]) -> SimulatedImu:
    """Build the IMU of a simulation with physics from `site`, the parts of the simulation. It is a
    `PhysicsFieldImu` for a car on rough ground, otherwise a `PhysicsImu`.
    """
    rough = site.robot.drive.kind == "ackermann" and site.world.ground is not None
    return PhysicsFieldImu.build(site) if rough else PhysicsImu.build(site)
