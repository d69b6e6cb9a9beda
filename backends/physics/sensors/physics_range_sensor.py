"""The range sensor of the simulated robot."""

from __future__ import annotations

from typing import Self

import numpy as np
from typing_extensions import override

from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.engine.engine import Engine
from handcart.backends.simulation.sensors.range_faults import NO_FAULTS, RangeFaults
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.numerics.arrays import FloatArray

from .physics_site import physics_of


class PhysicsRangeSensor(SimulatedRangeSensor):
    """Simulated lidar in a physics engine; its beams meet all bodies except the robot."""

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

    @classmethod
    @override
    def build(cls, site: SensorSite[RangeSpec]) -> Self:
        there, mount = physics_of(site), base_T_frame(site.robot.urdf_text(), site.link)
        faults = RangeFaults.of(site.robot.errors)
        return cls(site.spec, mount, there.body, there.engine, site.seed, faults)

    def _cast(self) -> FloatArray:
        reach = self._spec.reach_m
        pose = self._body.base_pose() @ self._base_T_sensor
        ends = self._ends @ pose[:3, :3].T + pose[:3, 3]
        return np.asarray(reach * self._engine.free_shares(pose[:3, 3], ends))
