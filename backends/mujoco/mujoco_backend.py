"""A robot in MuJoCo."""

from __future__ import annotations

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.sensors.simulated_camera import SceneCamera
from handcart.robotics.kinematics.arm_model import ArmModel

from .mujoco_body import MujocoBody
from .mujoco_engine import MujocoEngine


class MujocoBackend(PhysicsBackend):
    """See `PhysicsBackend`.

    What the camera sees is drawn from the scene, as on the kinematic backend; a resumed run goes on as one
    that wasn't stopped, to the last bit.

    How it differs from metal: links are rigid, contacts give by hundredths of a millimetre, a floor is flat,
    friction is Coulomb's, one coefficient for a pair, light has no shadows.
    """

    name = "mujoco"
    _engine: MujocoEngine

    def _start_engine(self, window: bool) -> MujocoEngine:
        return MujocoEngine(self.period)

    def _load_robot(self, robot: RobotFile) -> MujocoBody:
        return MujocoBody(self._engine, robot, self.scene.base)

    def _make_camera(self, spec: CameraSpec, arm: ArmModel) -> SceneCamera:
        return SceneCamera(self._robot, spec, self.scene, self._seed)
