"""A camera that sees what the scene holds."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.simulation.rendering.renderer import Renderer
from handcart.backends.simulation.scene import Scene
from handcart.backends.simulation.sensors.simulated_camera import SimulatedCamera


class SceneCamera(SimulatedCamera):
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
