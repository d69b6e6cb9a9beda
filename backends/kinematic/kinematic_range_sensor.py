"""The range sensor of the kinematic robot."""

from __future__ import annotations

import math

import numpy as np

from backends.range_sensor import RangeSensor, Scan
from backends.scene.keyed_noise import keyed
from backends.scene.ranges import cast_rays
from backends.scene.scene import Scene
from backends.scene.solids import FloorPlan
from backends.sensor_specs import RangeSpec
from robotics.geometry.pose2 import Pose2
from robotics.geometry.transform import Transform


class KinematicRangeSensor(RangeSensor):
    """Beams all round, all at the same instant, with Gaussian noise; nothing is black, bright or oblique."""

    def __init__(self, spec: RangeSpec, base_T_sensor: Transform, scene: Scene, seed: int) -> None:
        self._spec, self._scene, self._seed = spec, scene, seed
        yaw = math.atan2(base_T_sensor[1, 0], base_T_sensor[0, 0])
        self._mount = Pose2(float(base_T_sensor[0, 3]), float(base_T_sensor[1, 3]), yaw)
        height = float(base_T_sensor[2, 3])
        self._plan = FloorPlan(scene.solids, height, height)
        self._angles = np.linspace(-np.pi, np.pi, spec.beams, endpoint=False)
        self._now = 0
        self._last: tuple[int, Scan] | None = None

    def scan(self) -> Scan:
        """See `RangeSensor`."""
        if self._last is None or self._last[0] != self._now:
            self._last = (self._now, self._take())
        return self._last[1]

    def _take(self) -> Scan:
        scene, spec = self._scene, self._spec
        sensor = scene.base.compose(self._mount)
        ranges = cast_rays(self._plan, sensor, self._angles, scene.time, spec.reach_m)
        noise = keyed(self._seed, "range sensor", self._now).standard_normal(len(ranges))
        ranges = np.maximum(ranges + spec.sigma_mm / 1e3 * noise, 0.0)
        ranges[ranges > spec.reach_m] = np.inf
        return Scan(self._angles.copy(), ranges, self._mount)

    def advance(self, period: int) -> None:
        """A new period begins."""
        self._now = period
