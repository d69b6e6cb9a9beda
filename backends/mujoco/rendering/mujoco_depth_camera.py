"""Depth camera of a robot in MuJoCo."""

from __future__ import annotations

from functools import cached_property

from typing_extensions import override

from handcart.backends.mujoco.body.mujoco_body import MujocoBody
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.physics.sensors.engine_depth_camera import EngineDepthCamera
from handcart.backends.simulation.depth.simulated_depth_camera import TrueDepth
from handcart.robotics.geometry.transform import Transform

from .studio import Studio
from .style import Style

DEPTH_STYLE = Style(coloured=True, even=1.0, lamp=0.0, shadow_px=0, lit_m=1.0, samples=0)


class MujocoDepthCamera(EngineDepthCamera):
    """Simulated depth camera whose pictures are rendered by MuJoCo."""

    @cached_property
    def _studio(self) -> Studio:
        assert isinstance(self._engine, MujocoEngine)
        assert isinstance(self._body, MujocoBody)
        size = self._spec.width_px, self._spec.height_px
        return Studio(self._engine, self._body.looks(), DEPTH_STYLE, size)

    @override
    def _draw(self, world_T_camera: Transform) -> TrueDepth:
        return TrueDepth(*self._studio.take_with_depth(world_T_camera, self._spec.model.K))

    @override
    def close(self) -> None:
        if "_studio" in self.__dict__:
            self._studio.close()
