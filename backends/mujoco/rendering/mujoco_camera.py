"""The robot's camera, drawn by MuJoCo's renderer."""

from __future__ import annotations

from functools import cached_property

from typing_extensions import override

from handcart.backends.mujoco.body.mujoco_body import MujocoBody
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.physics.sensors.engine_camera import SAMPLES_PER_SIDE, EngineCamera
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .studio import Studio
from .style import CAMERA_STYLE


class MujocoCamera(EngineCamera):
    """Simulated camera whose pictures are rendered by MuJoCo."""

    @cached_property
    def studio(self) -> Studio:
        """Renderer that draws this camera's pictures of the engine's world, created on first use."""
        assert isinstance(self._engine, MujocoEngine)
        assert isinstance(self._body, MujocoBody)
        width, height = self._lens.size
        size = SAMPLES_PER_SIDE * width, SAMPLES_PER_SIDE * height
        return Studio(self._engine, self._body.looks(), CAMERA_STYLE, size)

    def _draw(self, world_T_camera: Transform, K: FloatArray, size: tuple[int, int]) -> ByteArray:
        picture: ByteArray = self.studio.take(world_T_camera, K, world_T_camera[:3, 3])[..., 1]
        return picture

    @override
    def close(self) -> None:
        if "studio" in self.__dict__:
            self.studio.close()
