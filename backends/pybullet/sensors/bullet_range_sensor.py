"""The range sensor of the simulated robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.pybullet.body.robot_body import RobotBody
from handcart.backends.pybullet.physics import ROBOT_GROUP, Physics
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.robotics.geometry.transform import Transform


class BulletRangeSensor(SimulatedRangeSensor):
    """Beams are tested in one batch against all bodies but the robot."""

    def __init__(
        self, spec: RangeSpec, base_T_sensor: Transform, body: RobotBody, physics: Physics, seed: int
    ) -> None:
        super().__init__(spec, base_T_sensor, seed)
        self._body, self._physics = body, physics
        self._base_T_sensor = base_T_sensor
        turned = np.column_stack((np.cos(self._angles), np.sin(self._angles), np.zeros(spec.beams)))
        self._ends = spec.reach_m * turned

    def _cast(self) -> NDArray[np.float64]:
        reach = self._spec.reach_m
        pose = self._body.base_pose() @ self._base_T_sensor
        ends = self._ends @ pose[:3, :3].T + pose[:3, 3]
        starts = np.broadcast_to(pose[:3, 3], ends.shape)
        hits = self._physics.p.rayTestBatch(
            starts.tolist(),
            ends.tolist(),
            numThreads=1,
            collisionFilterMask=~ROBOT_GROUP,
            physicsClientId=self._physics.client,
        )
        return np.array([reach * hit[2] if hit[0] >= 0 else np.inf for hit in hits])
