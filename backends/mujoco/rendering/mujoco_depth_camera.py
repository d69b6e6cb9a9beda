"""Depth camera of a robot in MuJoCo."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from typing_extensions import override

from handcart.backends.mujoco.body.mujoco_body import MujocoBody
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.physics.sensors.physics_site import physics_of
from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.backends.simulation.depth.scene_depth_camera import SceneDepthCamera
from handcart.backends.simulation.depth.simulated_depth_camera import SimulatedDepthCamera, TrueDepth
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite
from handcart.robotics.geometry.transform import Transform

from .studio import Studio
from .style import Style

DEPTH_STYLE = Style(coloured=True, even=1.0, lamp=0.0, shadow_px=0, lit_m=1.0, samples=0)


class MujocoDepthCamera(SimulatedDepthCamera):
    """Depth camera that MuJoCo renders: it sees the robot's own arm and rough ground, too."""

    @classmethod
    @override
    def build(cls, site: SensorSite[DepthCameraSpec]) -> SimulatedDepthCamera:
        """Build the camera that the world's file asks for."""
        return cls(site) if site.world.camera == "engine" else SceneDepthCamera(site)

    def __init__(self, site: SensorSite[Any]) -> None:
        super().__init__(site)
        self._parts = physics_of(site)

    @cached_property
    def _studio(self) -> Studio:
        engine, body, _ = self._parts
        assert isinstance(engine, MujocoEngine)
        assert isinstance(body, MujocoBody)
        size = self._spec.width_px, self._spec.height_px
        return Studio(engine, body.looks(), DEPTH_STYLE, size)

    @override
    def _draw(self, world_T_camera: Transform) -> TrueDepth:
        return TrueDepth(*self._studio.take_with_depth(world_T_camera, self._spec.model.K))

    @override
    def close(self) -> None:
        if "_studio" in self.__dict__:
            self._studio.close()
