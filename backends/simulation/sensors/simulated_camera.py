"""Cameras of simulated backends: their common base, and one that renders the scene."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import ClassVar, Self

from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.plain_values import Kinds
from handcart.backends.robot.mounted_camera import MountedCamera, camera_mount, known_camera
from handcart.backends.robot.placed_camera import PlacedCamera
from handcart.backends.simulation.rendering.renderer import Renderer
from handcart.backends.simulation.sensors.true_camera import true_camera
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import ByteArray

from .simulated_sensor import SensorSite, SimulatedSensor


class SimulatedCamera(PlacedCamera, SimulatedSensor):
    """Camera that takes pictures on demand with its true lens and pose.

    It reports the nominal lens and pose of the robot's file, which differ from the true ones by `errors`.
    """

    STATE: ClassVar[Kinds] = {"_now": int}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, robot: RobotFile, spec: CameraSpec, arm: ArmModel | None, seed: int) -> None:
        """Mount the camera at its link of the URDF, with the errors of mount and focal length in `errors`.

        Args:
            robot: robot file.
            spec: section of the camera in that file.
            arm: model of the arm; None without an arm.
            seed: seed of the errors.
        """
        self._errors, self._spec, self._seed = robot.errors, spec, seed
        self._mount = camera_mount(robot, robot.link_of(spec), arm)
        self._known = known_camera(spec, self._mount)
        self._now = 0
        self._last: tuple[int, ByteArray] | None = None

    @cached_property
    def _true(self) -> MountedCamera:
        return true_camera(self._spec, self._mount, self._errors, self._seed)

    @abstractmethod
    def _take(self) -> ByteArray:
        """Return this period's picture (h, w)."""

    @override
    def image(self) -> ByteArray:
        if self._last is None or self._last[0] != self._now:
            picture = self._take()
            picture.flags.writeable = False
            self._last = (self._now, picture)
        return self._last[1]

    def advance(self, period: int) -> None:
        """Begin a new period, in which the next request takes a new picture."""
        self._now = period


class SceneCamera(SimulatedCamera):
    """Simulated camera that draws its pictures from the scene's bodies, without a physics engine."""

    def __init__(self, robot: RobotFile, spec: CameraSpec, scene: Scene, seed: int) -> None:
        super().__init__(robot, spec, scene.arm, seed)
        self._scene = scene

    @classmethod
    @override
    def build(cls, site: SensorSite[CameraSpec]) -> Self:
        return cls(site.robot, site.spec, site.scene, site.seed)

    @cached_property
    def _renderer(self) -> Renderer:
        return Renderer(self._true.model, self._scene.robot.errors, self._seed)

    def _take(self) -> ByteArray:
        pose = self._scene.world_T(self.carrier) @ self._true.carrier_T_camera
        return self._renderer.render(self._scene, pose, self._now)
