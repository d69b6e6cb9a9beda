"""The range sensor of the kinematic robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.simulation.scene import Scene
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.backends.simulation.world.solids import FloorPlan
from handcart.robotics.geometry.transform import Transform


class KinematicRangeSensor(SimulatedRangeSensor):
    """Casts rays in the floor plan at its height."""

    def __init__(self, spec: RangeSpec, base_T_sensor: Transform, scene: Scene, seed: int) -> None:
        super().__init__(spec, base_T_sensor, seed)
        self._scene = scene
        height = float(base_T_sensor[2, 3])
        self._plan = FloorPlan(scene.solids, height, height)

    def _cast(self) -> NDArray[np.float64]:
        sensor = self._scene.base.compose(self._mount)
        return cast_rays(self._plan, sensor, self._angles, self._scene.time, self._spec.reach_m)
