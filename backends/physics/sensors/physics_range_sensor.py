"""The range sensor of the simulated robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.engine import Engine
from handcart.backends.simulation.sensors.range_faults import NO_FAULTS, RangeFaults
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.robotics.geometry.transform import Transform


class PhysicsRangeSensor(SimulatedRangeSensor):
    """Beams are tested in one batch against all bodies but the robot."""

    def __init__(
        self,
        spec: RangeSpec,
        base_T_sensor: Transform,
        body: RobotBody,
        engine: Engine,
        seed: int,
        faults: RangeFaults = NO_FAULTS,
    ) -> None:
        super().__init__(spec, base_T_sensor, seed, faults)
        self._body, self._engine = body, engine
        self._base_T_sensor = base_T_sensor
        turned = np.column_stack((np.cos(self._angles), np.sin(self._angles), np.zeros(spec.beams)))
        self._ends = spec.reach_m * turned

    def _cast(self) -> NDArray[np.float64]:
        reach = self._spec.reach_m
        pose = self._body.base_pose() @ self._base_T_sensor
        ends = self._ends @ pose[:3, :3].T + pose[:3, 3]
        return np.asarray(reach * self._engine.free_shares(pose[:3, 3], ends))
