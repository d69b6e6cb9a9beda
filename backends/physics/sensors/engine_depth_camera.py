"""Depth camera of a robot in physics, drawn by the engine's renderer."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.backends.simulation.depth.scene_depth_camera import SceneDepthCamera
from handcart.backends.simulation.depth.simulated_depth_camera import SimulatedDepthCamera
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite

from .physics_site import physics_of


class EngineDepthCamera(SimulatedDepthCamera):
    """Base class of depth cameras whose pictures a physics engine renders.

    Unlike those of `SceneDepthCamera`, the pictures show the robot's own arm and rough ground.
    """

    @classmethod
    @override
    def build(cls, site: SensorSite[DepthCameraSpec]) -> SimulatedDepthCamera:
        """Build a depth camera from `site`, the parts of the simulation. The world's file names its renderer:
        that of the physics engine, or the ray caster for simulated scenes.
        """
        return cls(site) if site.world.camera == "engine" else SceneDepthCamera(site)

    def __init__(self, site: SensorSite[DepthCameraSpec]) -> None:
        super().__init__(site)
        self._engine, self._body, _ = physics_of(site)
