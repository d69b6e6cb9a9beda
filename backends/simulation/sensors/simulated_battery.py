"""The battery of a simulated robot."""

from __future__ import annotations

import math
from typing import ClassVar, Self

from typing_extensions import override

from handcart.backends.capabilities.battery import Battery
from handcart.backends.sensors.battery_spec import BatterySpec
from handcart.backends.simulation.noise.keyed_noise import keyed_normal
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.pose2 import Pose2

from .simulated_sensor import SensorSite, SimulatedSensor

J_PER_WH = 3600.0


class SimulatedBattery(Battery, SimulatedSensor):
    """Simulated battery of a robot, discharged by time and the base's motion, and charged by a charger."""

    STATE: ClassVar = {"_energy_j": float, "_place": Pose2, "_now": int}

    def __init__(self, spec: BatterySpec, scene: Scene, period: float, seed: int) -> None:
        """Prepare the battery at its initial charge.

        Args:
            spec: the battery's section of the robot's file.
            scene: true state of the world, with the motion of the base.
            period: control period, in [s].
            seed: seed of the reading's noise.
        """
        self._spec, self._scene, self._period, self._seed = spec, scene, period, seed
        self._full_j = J_PER_WH * spec.capacity_wh
        self._energy_j = spec.charge_percent / 100.0 * self._full_j
        self._place, self._now = scene.base, 0

    @classmethod
    @override
    def build(cls, site: SensorSite[BatterySpec]) -> Self:
        return cls(site.spec, site.scene, site.period, site.seed)

    @override
    def charge_percent(self) -> float:
        noise = self._spec.sigma_percent * keyed_normal(self._seed, "battery", self._now, 1)[0]
        return float(min(100.0, max(0.0, 100.0 * self._energy_j / self._full_j + noise)))

    @override
    def advance(self, period: int) -> None:
        spec, base = self._spec, self._scene.base
        moved = base.relative_to(self._place)
        used = spec.drive_j_m * math.hypot(moved.x, moved.y) + spec.turn_j_rad * abs(moved.theta)
        used += spec.idle_w * self._period
        charger = spec.charger
        if charger and math.hypot(base.x - charger.x_m, base.y - charger.y_m) <= charger.within_mm / 1e3:
            used -= charger.power_w * self._period
        self._energy_j = min(self._full_j, max(0.0, self._energy_j - used))
        self._place, self._now = base, period
