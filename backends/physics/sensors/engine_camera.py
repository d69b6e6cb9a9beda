"""The camera of a robot in physics, drawn by the engine's renderer."""

from __future__ import annotations

from abc import abstractmethod

import cv2
import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.engine.engine import Engine
from handcart.backends.physics.world.world_bodies import WorldBodies
from handcart.backends.simulation.rendering.lens import Lens
from handcart.backends.simulation.sensors.simulated_camera import SceneCamera, SimulatedCamera
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .physics_site import physics_of

# along each side of a pixel, which takes in light from all of its area: edges have no steps
SAMPLES_PER_SIDE = 2


class EngineCamera(SimulatedCamera):
    """Base class of cameras whose pictures a physics engine renders.

    The picture of an ideal pinhole camera gets the lens, light and noise of the robot's file. `SceneCamera`
    has another renderer: if perception gives the same result with both cameras, the result does not come from
    a fault of one renderer. Light comes from everywhere, and there are no shadows.
    """

    def __init__(
        self,
        robot: RobotFile,
        spec: CameraSpec,
        arm: ArmModel | None,
        body: RobotBody,
        world: WorldBodies,
        engine: Engine,
        seed: int,
    ) -> None:
        super().__init__(robot, spec, arm, seed)
        self._lens = Lens(self._true.model, robot.errors, seed)
        self._body, self._world, self._engine = body, world, engine

    @classmethod
    @override
    def build(cls, site: SensorSite[CameraSpec]) -> SimulatedCamera:
        """Build a camera from `site`, the parts of the simulation. The world's file names its renderer: that
        of the physics engine, or `SceneCamera`.
        """
        if site.world.camera != "engine":
            return SceneCamera.build(site)
        engine, body, world = physics_of(site)
        return cls(site.robot, site.spec, site.scene.arm, body, world, engine, site.seed)

    @abstractmethod
    def _draw(self, world_T_camera: Transform, K: FloatArray, size: tuple[int, int]) -> ByteArray:
        """Return the picture (height, width), grey, of a pinhole camera, without lens and noise.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.
            size: width and height in [px].
        """

    def _take(self) -> ByteArray:
        world_T_camera = self._body.link_pose(self.carrier) @ self._true.carrier_T_camera
        return self._lens.take(self.ideal(world_T_camera), self._now)

    def ideal(self, world_T_camera: Transform) -> ByteArray:
        """Return the grey picture (h, w) of a pinhole camera, before lens, light and noise.

        It is larger than the camera's picture, so that it contains all rays that the lens bends into the
        camera's picture.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
        """
        for thing in self._world.things.values():
            thing.look(world_T_camera[:3, 3])
        width, height = self._lens.size
        K = self._lens.K * [[SAMPLES_PER_SIDE], [SAMPLES_PER_SIDE], [1.0]]
        K[:2, 2] += (SAMPLES_PER_SIDE - 1) / 2
        fine = self._draw(world_T_camera, K, (SAMPLES_PER_SIDE * width, SAMPLES_PER_SIDE * height))
        return np.asarray(cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)
