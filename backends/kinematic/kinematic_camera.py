"""The camera of the kinematic robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from backends.camera import Camera
from backends.robot_file import CameraSpec, RobotFile
from backends.scene.lens import camera_model
from backends.scene.renderer import Renderer
from backends.scene.scene import Scene
from robotics.geometry.transform import Transform, inverse
from robotics.perception.camera_model import CameraModel


class KinematicCamera(Camera):
    """Renders on demand, once a period. Calibration is exact: model and mount are as stated."""

    def __init__(self, robot: RobotFile, spec: CameraSpec, scene: Scene, seed: int) -> None:
        if scene.arm is None:
            raise ValueError("the camera needs an arm that carries it")
        self._model = camera_model(spec)
        self._scene = scene
        joints = scene.joints
        self._mount = inverse(scene.arm.forward(joints)) @ scene.arm.forward(joints, "camera")
        self._renderer = Renderer(self._model, robot.errors, seed)
        self._now = 0
        self._last: tuple[int, NDArray[np.uint8]] | None = None

    def image(self) -> NDArray[np.uint8]:
        """See `Camera`."""
        if self._last is None or self._last[0] != self._now:
            pose = self._scene.world_T("hand") @ self._mount
            picture = self._renderer.render(self._scene, pose, self._now)
            picture.flags.writeable = False
            self._last = (self._now, picture)
        return self._last[1]

    @property
    def model(self) -> CameraModel:
        """See `Camera`."""
        return self._model

    @property
    def hand_T_camera(self) -> Transform:
        """See `Camera`."""
        return self._mount.copy()

    def advance(self, period: int) -> None:
        """A new period begins."""
        self._now = period
