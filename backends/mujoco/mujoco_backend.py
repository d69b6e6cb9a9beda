"""A robot in MuJoCo."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.physics.onlooker import Onlooker
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.sensors.scene_camera import SceneCamera
from handcart.robotics.kinematics.arm_model import ArmModel

from .mujoco_body import MujocoBody
from .mujoco_engine import MujocoEngine
from .rendering.studio import Studio
from .rendering.style import FILM

VIEW_SIZE = (1280, 720)  # [px]
_FOCAL = 1000.0  # [px]


class MujocoBackend(PhysicsBackend):
    """See `PhysicsBackend`.

    What the camera sees is drawn from the scene, as on the kinematic backend; a resumed run goes on as one
    that wasn't stopped, to the last bit.

    How it differs from metal: links are rigid, contacts give by hundredths of a millimetre, a floor is flat,
    friction is Coulomb's, one coefficient for a pair, light has no shadows.
    """

    name = "mujoco"
    _engine: MujocoEngine
    _body: MujocoBody

    def _start_engine(self, window: bool) -> MujocoEngine:
        return MujocoEngine(self.period)

    def _load_robot(self, robot: RobotFile) -> MujocoBody:
        return MujocoBody(self._engine, robot, self.scene.base)

    def _make_camera(self, spec: CameraSpec, arm: ArmModel) -> SceneCamera:
        return SceneCamera(self._robot, spec, self.scene, self._seed)

    def view(self) -> NDArray[np.uint8]:
        """See `Backend`."""
        width, height = VIEW_SIZE
        K = np.array([[_FOCAL, 0.0, (width - 1) / 2], [0.0, _FOCAL, (height - 1) / 2], [0.0, 0.0, 1.0]])
        pose = self._onlooker.look(self._body.standing_pose(), self.scene.time)
        return self._studio.take(pose, K, self._onlooker.at)

    @cached_property
    def _studio(self) -> Studio:
        return Studio(self._engine, self._body.looks(), FILM, VIEW_SIZE)

    @cached_property
    def _onlooker(self) -> Onlooker:
        return Onlooker(self._engine)

    def close(self) -> None:
        """See `Backend`."""
        if "_studio" in self.__dict__:
            self._studio.close()
        super().close()
