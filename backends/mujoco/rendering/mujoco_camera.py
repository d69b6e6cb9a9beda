"""The robot's camera, drawn by MuJoCo's renderer."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.mujoco.body.mujoco_body import MujocoBody
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.physics.sensors.engine_camera import SAMPLES_PER_SIDE, EngineCamera
from handcart.backends.physics.sensors.physics_site import physics_of
from handcart.backends.physics.world.world_bodies import WorldBodies
from handcart.backends.simulation.sensors.simulated_camera import SceneCamera, SimulatedCamera
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel

from .studio import Studio
from .style import CAMERA_STYLE


class MujocoCamera(EngineCamera):
    """Camera that MuJoCo renders."""

    def __init__(
        self,
        robot: RobotFile,
        spec: CameraSpec,
        arm: ArmModel | None,
        body: MujocoBody,
        world: WorldBodies,
        engine: MujocoEngine,
        seed: int,
    ) -> None:
        super().__init__(robot, spec, arm, body, world, seed)
        self._engine, self._robot_body = engine, body

    @classmethod
    @override
    def build(cls, site: SensorSite[CameraSpec]) -> SimulatedCamera:
        """Build the camera that the world's file asks for."""
        if site.world.camera != "engine":
            return SceneCamera.build(site)
        engine, body, world = physics_of(site)
        assert isinstance(engine, MujocoEngine)
        assert isinstance(body, MujocoBody)
        return cls(site.robot, site.spec, site.scene.arm, body, world, engine, site.seed)

    @cached_property
    def studio(self) -> Studio:
        """Return the studio that takes its pictures."""
        width, height = self._lens.size
        size = SAMPLES_PER_SIDE * width, SAMPLES_PER_SIDE * height
        return Studio(self._engine, self._robot_body.looks(), CAMERA_STYLE, size)

    def _draw(
        self, world_T_camera: Transform, K: NDArray[np.float64], size: tuple[int, int]
    ) -> NDArray[np.uint8]:
        picture: NDArray[np.uint8] = self.studio.take(world_T_camera, K, world_T_camera[:3, 3])[..., 1]
        return picture

    @override
    def close(self) -> None:
        if "studio" in self.__dict__:
            self.studio.close()
