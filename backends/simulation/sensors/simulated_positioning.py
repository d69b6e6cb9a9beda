"""The indoor positioning of a simulated robot."""

from __future__ import annotations

import math
from typing import ClassVar, Self

from typing_extensions import override

from handcart.backends.capabilities.positioning import PoseReading, Positioning
from handcart.backends.description.sensor_specs import PositioningSpec
from handcart.backends.simulation.noise.keyed_noise import keyed_normal
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.pose2 import Pose2

from .simulated_sensor import SensorSite, SimulatedSensor

_ROUNDING = 1e-9


class SimulatedPositioning(Positioning, SimulatedSensor):
    """Simulated external positioning system, which reports the robot's true pose with white noise.

    It measures at its own rate and reports after its latency. The robot is always in its sight, its readings
    have no gross errors, and its frame is that of the map.
    """

    SETTLED_FIRST = True
    STATE: ClassVar = {
        "_now": int,
        "_taken": int,
        "_under_way": tuple[tuple[int, Pose2, float], ...],
        "_last": tuple[int, Pose2, float] | None,
    }
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, spec: PositioningSpec, scene: Scene, period: float, seed: int) -> None:
        """Prepare the system, and take the first measurement.

        Args:
            spec: the system's section of the robot's file.
            scene: true state of the world.
            period: control period, in [s].
            seed: seed of the noise.
        """
        self._spec, self._scene, self._period, self._seed = spec, scene, period, seed
        self._now, self._taken = 0, 0
        self._under_way: tuple[tuple[int, Pose2, float], ...] = ()
        """Readings that haven't arrived yet, each with number, map_T_base, and time of the measurement in
        [s].
        """
        self._last: tuple[int, Pose2, float] | None = None
        self._take()

    @classmethod
    @override
    def build(cls, site: SensorSite[PositioningSpec]) -> Self:
        return cls(site.spec, site.scene, site.period, site.seed)

    @override
    def reading(self) -> PoseReading | None:
        if self._last is None:
            return None
        number, pose, when = self._last
        return PoseReading(number, pose, self._now * self._period - when)

    def advance(self, period: int) -> None:
        """Take the measurements due by the control period with number `period`, and report those whose
        latency has passed.
        """
        self._now = period
        self._take()

    def _take(self) -> None:
        """Measure at the system's own rate, and report the readings whose latency is over."""
        time = self._now * self._period
        due = math.floor(time * self._spec.rate_hz + _ROUNDING) + 1
        if due > self._taken:
            self._taken = due
            self._under_way += ((due, self._measured(due), time),)
        arrived = [item for item in self._under_way if item[2] + self._spec.latency_s <= time + _ROUNDING]
        if arrived:
            self._last = arrived[-1]
            self._under_way = self._under_way[len(arrived) :]

    def _measured(self, number: int) -> Pose2:
        x, y, theta = self._scene.base
        sigma, turn = self._spec.sigma_mm / 1e3, self._spec.heading_sigma_mrad / 1e3
        dx, dy, angle = keyed_normal(self._seed, "positioning", number, 3).tolist()
        return Pose2(x + sigma * dx, y + sigma * dy, theta + turn * angle)
