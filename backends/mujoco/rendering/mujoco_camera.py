"""The robot's camera, drawn by MuJoCo's renderer."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.mujoco.body.mujoco_body import MujocoBody
from handcart.backends.mujoco.mujoco_engine import MujocoEngine
from handcart.backends.physics.sensors.engine_camera import SAMPLES_PER_SIDE, EngineCamera
from handcart.backends.physics.world.world_bodies import WorldBodies
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
        arm: ArmModel,
        body: MujocoBody,
        world: WorldBodies,
        engine: MujocoEngine,
        seed: int,
    ) -> None:
        super().__init__(robot, spec, arm, body, world, seed)
        self._engine, self._robot_body = engine, body

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

    def close(self) -> None:
        """Let go of OpenGL; a second call does nothing."""
        if "studio" in self.__dict__:
            self.studio.close()
