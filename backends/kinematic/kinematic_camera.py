"""The camera of the kinematic robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from backends.camera import Camera
from backends.mounted_camera import known_camera
from backends.robot_file import RobotFile
from backends.scene.renderer import Renderer
from backends.scene.scene import Scene
from backends.scene.true_camera import true_camera
from backends.sensor_specs import CameraSpec
from robotics.geometry.transform import Transform
from robotics.perception.camera_model import CameraModel


class KinematicCamera(Camera):
    """Renders on demand, once a period, what the true camera sees; its model and mount are those known."""

    def __init__(self, robot: RobotFile, spec: CameraSpec, scene: Scene, seed: int) -> None:
        if scene.arm is None:
            raise ValueError("the camera needs an arm that carries it")
        self._known = known_camera(spec, scene.arm)
        self._true = true_camera(spec, scene.arm, robot.errors, seed)
        self._scene = scene
        self._renderer = Renderer(self._true.model, robot.errors, seed)
        self._now = 0
        self._last: tuple[int, NDArray[np.uint8]] | None = None

    def image(self) -> NDArray[np.uint8]:
        """See `Camera`."""
        if self._last is None or self._last[0] != self._now:
            pose = self._scene.world_T("hand") @ self._true.hand_T_camera
            picture = self._renderer.render(self._scene, pose, self._now)
            picture.flags.writeable = False
            self._last = (self._now, picture)
        return self._last[1]

    @property
    def model(self) -> CameraModel:
        """See `Camera`."""
        return self._known.model

    @property
    def hand_T_camera(self) -> Transform:
        """See `Camera`."""
        return self._known.hand_T_camera.copy()

    def advance(self, period: int) -> None:
        """A new period begins."""
        self._now = period
