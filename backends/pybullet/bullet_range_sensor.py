"""The range sensor of the simulated robot."""

from __future__ import annotations

import math

import numpy as np

from backends.range_sensor import RangeSensor, Scan
from backends.scene.keyed_noise import keyed
from backends.sensor_specs import RangeSpec
from robotics.geometry.pose2 import Pose2
from robotics.geometry.transform import Transform

from .physics import ROBOT_GROUP, Physics
from .robot_body import RobotBody


class BulletRangeSensor(RangeSensor):
    """Beams all round, tested in one batch against all bodies but the robot, with Gaussian noise."""

    def __init__(
        self, spec: RangeSpec, base_T_sensor: Transform, body: RobotBody, physics: Physics, seed: int
    ) -> None:
        """`base_T_sensor` (4, 4) is where the URDF mounts it."""
        self._spec, self._body, self._physics, self._seed = spec, body, physics, seed
        yaw = math.atan2(base_T_sensor[1, 0], base_T_sensor[0, 0])
        self._mount = Pose2(float(base_T_sensor[0, 3]), float(base_T_sensor[1, 3]), yaw)
        self._base_T_sensor = base_T_sensor
        self._angles = np.linspace(-np.pi, np.pi, spec.beams, endpoint=False)
        turned = np.column_stack((np.cos(self._angles), np.sin(self._angles), np.zeros(spec.beams)))
        self._ends = spec.reach_m * turned
        self._now = 0
        self._last: tuple[int, Scan] | None = None

    def scan(self) -> Scan:
        """See `RangeSensor`."""
        if self._last is None or self._last[0] != self._now:
            self._last = (self._now, self._take())
        return self._last[1]

    def _take(self) -> Scan:
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
        ranges = np.array([reach * hit[2] if hit[0] >= 0 else np.inf for hit in hits])
        noise = keyed(self._seed, "range sensor", self._now).standard_normal(len(ranges))
        ranges = np.maximum(ranges + self._spec.sigma_mm / 1e3 * noise, 0.0)
        ranges[ranges > reach] = np.inf
        return Scan(self._angles.copy(), ranges, self._mount)

    def begin(self, period: int) -> None:
        """A new period begins."""
        self._now = period
