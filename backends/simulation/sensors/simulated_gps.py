"""The satellite receiver of a simulated robot."""

from __future__ import annotations

import math
from typing import ClassVar, Self

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.gps import Fix, Gps
from handcart.backends.description.ground_spec import GpsSpec
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.world_file import SkySpec
from handcart.robotics.far import Far
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.numerics.arrays import FloatArray

from .simulated_sensor import SensorSite, SimulatedSensor


class SimulatedGps(Gps, SimulatedSensor):
    """Simulated GNSS receiver.

    White noise and slow drift come from the robot's file; reflections, outliers and outages come from the
    world's file.
    """

    STATE: ClassVar = {
        "_fix": Fix | None,
        "_drift": FloatArray,
        "_count": int,
        "_spell": int,
        "_until": Far,
        "_off": FloatArray,
    }

    def __init__(
        self,
        spec: GpsSpec,
        sky: SkySpec,
        scene: Scene,
        period: float,
        seed: int,
        antenna: FloatArray | None = None,
    ) -> None:
        """Prepare a receiver.

        Args:
            spec: the receiver's section of the robot's file.
            sky: disturbances of the world's file.
            scene: true state of the world.
            period: control period, in [s].
            seed: seed of the errors.
            antenna: (3,) position of the antenna in the base frame, in [m] (default: that of the robot's
                first receiver).
        """
        self._spec, self._sky, self._scene, self._seed = spec, sky, scene, seed
        self._every = max(1, round(spec.period_s / period))
        self._antenna = np.array([*(scene.robot.antenna if antenna is None else antenna), 1.0])
        self._fix: Fix | None = None
        self._drift = spec.drift_m * keyed(seed, "gps drift").standard_normal(2)
        self._count, self._spell, self._off = 0, 0, np.zeros(2)
        self._until = self._next_spell()

    @classmethod
    @override
    def build(cls, site: SensorSite[GpsSpec]) -> Self:
        antenna = base_T_frame(site.robot.urdf_text(), site.link)[:3, 3]
        return cls(site.spec, site.world.sky, site.scene, site.period, site.seed, antenna)

    @override
    def fix(self) -> Fix | None:
        return self._fix

    def advance(self, period: int) -> None:
        """Measure a position fix if one is due in this period and no outage lasts; otherwise report no
        fix.
        """
        self._fix = None
        if period % self._every:
            return
        self._count += 1
        draws = keyed(self._seed, "gps", self._count).standard_normal((3, 2))
        odd = keyed(self._seed, "gps outliers", self._count).random() < self._sky.outlier_percent / 100
        keep = math.exp(-self._spec.period_s / self._spec.drift_time_s)
        self._drift = keep * self._drift + self._spec.drift_m * math.sqrt(1.0 - keep * keep) * draws[0]
        self._reflect()
        if any(outage.from_s <= self._scene.time < outage.to_s for outage in self._sky.outages):
            return
        off = self._drift + self._spec.white_m * draws[1] + self._off
        place = (self._scene.world_T_base @ self._antenna)[:2] + off
        self._fix = Fix(place + (self._sky.outlier_m * draws[2] if odd else 0.0), self._spec.white_m)

    def _reflect(self) -> None:
        """Begin or end a reflection (multipath), which adds an offset to the fixes; times with odd numbers
        are reflections.
        """
        while self._scene.time >= self._until:
            self._spell += 1
            reflected = self._spell % 2 == 1
            draw = keyed(self._seed, "reflections", self._spell)
            self._off = self._sky.reflection_m * draw.standard_normal(2) if reflected else np.zeros(2)
            self._until += draw.exponential(self._sky.reflection_s) if reflected else self._next_spell()

    def _next_spell(self) -> float:
        every = self._sky.reflection_every_s
        if every is None:
            return math.inf
        return float(keyed(self._seed, "reflections wait", self._spell).exponential(every))
