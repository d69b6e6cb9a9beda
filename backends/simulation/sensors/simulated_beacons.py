"""The radio beacons of a simulated robot."""

from __future__ import annotations

import math
from typing import ClassVar, Self

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.beacons import BeaconRanges, Beacons
from handcart.backends.description.beacons_spec import BeaconsSpec
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.world_file import BeaconsThere
from handcart.robotics.numerics.arrays import FloatArray

from .simulated_sensor import SensorSite, SimulatedSensor


class SimulatedBeacons(Beacons, SimulatedSensor):
    """Ranges to radio beacons, with errors from the robot's and the world's file.

    The robot's file sets white noise, a bias for each beacon and a scale error of all ranges. The world's
    file sets the beacons' true positions and the random walk of their biases. Nothing obstructs the signals.
    """

    STATE: ClassVar = {"_ranges": BeaconRanges | None, "_bias": FloatArray}

    def __init__(
        self, spec: BeaconsSpec, there: BeaconsThere, scene: Scene, period: float, seed: int
    ) -> None:
        """Prepare the beacons, and draw the errors that stay the same for a run.

        Args:
            spec: the beacons' section of the robot's file.
            there: differences of the true beacons, from the world's file.
            scene: true state of the world.
            period: control period, in [s].
            seed: seed of the errors.
        """
        self._spec, self._there, self._scene, self._seed = spec, there, scene, seed
        self._every = max(1, round(spec.period_s / period))
        self._walk = there.bias_walk_m_rt_s * math.sqrt(self._every * period)
        self._nominal = np.array(list(spec.places_m.values()))
        self._moved = np.array([there.places_m.get(name, place) for name, place in spec.places_m.items()])
        self._bias = spec.bias_m * keyed(seed, "beacon biases").standard_normal(len(self._nominal))
        self._scale = 1.0 + spec.scale_percent / 100 * keyed(seed, "beacon scale").standard_normal()
        self._ranges: BeaconRanges | None = None

    @classmethod
    @override
    def build(cls, site: SensorSite[BeaconsSpec]) -> Self:
        return cls(site.spec, site.world.beacons, site.scene, site.period, site.seed)

    @override
    def ranges(self) -> BeaconRanges | None:
        return self._ranges

    def advance(self, period: int) -> None:
        """Measure the ranges to the beacons if a measurement is due in this period; otherwise report no
        ranges.
        """
        self._ranges = None
        if period % self._every:
            return
        draws = keyed(self._seed, "beacons", period).standard_normal((2, len(self._nominal)))
        self._bias = self._bias + self._walk * draws[0]
        places = self._moved if self._scene.time >= self._there.moved_at_s else self._nominal
        tag = (self._scene.world_T_base @ np.array([*self._spec.tag_m, 1.0]))[:3]
        true = np.linalg.norm(places - tag, axis=1)
        heard = np.where(true <= self._spec.reach_m, true, math.nan)
        self._ranges = BeaconRanges(self._scale * heard + self._bias + self._spec.sigma_m * draws[1])
