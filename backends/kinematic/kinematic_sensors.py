"""Camera and range sensor of the kinematic robot."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec, RangeSpec
from handcart.backends.simulation.rendering.renderer import Renderer
from handcart.backends.simulation.scene import Scene
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.sensors.simulated_camera import SimulatedCamera
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.backends.simulation.world.solids import FloorPlan
from handcart.robotics.geometry.transform import Transform


class KinematicCamera(SimulatedCamera):
    """Renders the scene's faces."""

    def __init__(self, robot: RobotFile, spec: CameraSpec, scene: Scene, seed: int) -> None:
        if scene.arm is None:
            raise ValueError("the camera needs an arm that carries it")
        super().__init__(robot, spec, scene.arm, seed)
        self._scene = scene

    @cached_property
    def _renderer(self) -> Renderer:
        return Renderer(self._true.model, self._scene.robot.errors, self._seed)

    def _take(self) -> NDArray[np.uint8]:
        pose = self._scene.world_T("hand") @ self._true.hand_T_camera
        return self._renderer.render(self._scene, pose, self._now)


class KinematicRangeSensor(SimulatedRangeSensor):
    """Casts rays in the floor plan at its height."""

    def __init__(self, spec: RangeSpec, base_T_sensor: Transform, scene: Scene, seed: int) -> None:
        super().__init__(spec, base_T_sensor, seed)
        self._scene = scene
        height = float(base_T_sensor[2, 3])
        self._plan = FloorPlan(scene.solids, height, height)

    def _cast(self) -> NDArray[np.float64]:
        sensor = self._scene.base.compose(self._mount)
        return cast_rays(self._plan, sensor, self._angles, self._scene.time, self._spec.reach_m)
