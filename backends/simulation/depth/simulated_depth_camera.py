"""Depth cameras of simulated backends: their common base."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import ClassVar, NamedTuple

import cv2
import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.depth_camera import DepthCamera, DepthImage
from handcart.backends.plain_values import Kinds
from handcart.backends.robot.mounted_camera import camera_mount
from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite, SimulatedSensor
from handcart.backends.simulation.sensors.true_camera import mount_error
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .depth_noise import DepthNoise


class TrueDepth(NamedTuple):
    """Colour picture and depth picture that a depth camera without errors would take."""

    colour: ByteArray
    """Colours (height, width, 3) in RGB, 0 to 255."""
    depth: FloatArray
    """Depths (height, width) in [m] along the optical axis; infinite where nothing is."""


class SimulatedDepthCamera(DepthCamera, SimulatedSensor):
    """Depth camera that takes a picture from its true pose when it is read, at most once a period.

    The pose that comes with the picture follows from the measured joints and the URDF. The true pose
    differs from it by the joints' errors, and by the mount's errors under `errors` of the camera's spec.
    """

    STATE: ClassVar[Kinds] = {"_now": int}

    def __init__(self, site: SensorSite[DepthCameraSpec]) -> None:
        """Build the camera of a site."""
        self._site, self._spec, self._now = site, site.spec, 0
        self._mount = camera_mount(site.robot, site.link, site.scene.arm)
        self._last: tuple[int, DepthImage] | None = None

    @abstractmethod
    def _draw(self, world_T_camera: Transform) -> TrueDepth:
        """Return the picture and depth of a perfect depth camera.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
        """

    @override
    def image(self) -> DepthImage:
        if self._last is None or self._last[0] != self._now:
            self._last = (self._now, self._take())
        return self._last[1]

    @property
    @override
    def model(self) -> CameraModel:
        return self._spec.model

    @override
    def advance(self, period: int) -> None:
        self._now = period

    @cached_property
    def _noise(self) -> DepthNoise:
        return DepthNoise(self._spec, self._site.seed)

    @cached_property
    def _mount_error(self) -> Transform:
        return mount_error(self._site.robot.errors, self._site.seed)

    def _take(self) -> DepthImage:
        true = self._draw(self.true_pose())
        depth = self._noise.read(true.depth, self._now)
        image = DepthImage(
            self._exposed(true.colour), depth, self._measured_pose(), self._now * self._site.period
        )
        for part in (image.colour, image.depth, image.base_T_camera):
            part.flags.writeable = False
        return image

    def true_pose(self) -> Transform:
        """Return the true world_T_camera (4, 4) of the optical frame (z forward, x right, y down)."""
        world_T_carrier = self._site.scene.world_T(self._mount.carrier)
        return world_T_carrier @ self._mount.carrier_T_frame @ self._mount_error

    def _measured_pose(self) -> Transform:
        arm, carrier = self._site.scene.arm, self._mount.carrier
        if arm is None:
            base_T_carrier = base_T_frame(self._site.robot.urdf_text(), carrier)
        else:
            base_T_carrier = arm.forward(self._site.joints(), carrier)
        return base_T_carrier @ self._mount.carrier_T_frame

    def _exposed(self, colour: ByteArray) -> ByteArray:
        """Return the colours (h, w, 3) in RGB with the blur and the noise of the robot's file, given those of
        a perfect camera.
        """
        errors = self._site.robot.errors
        if errors.image_blur_px > 0.0:
            colour = np.asarray(cv2.GaussianBlur(colour, (5, 5), errors.image_blur_px), np.uint8)
        rng = keyed(self._site.seed, "depth colour", self._now)
        noise = rng.standard_normal((*colour.shape[:2], 1), np.float32)
        noisy = np.rint(colour + np.float32(errors.image_noise_grey) * noise)
        return np.asarray(np.clip(noisy, 0, 255), dtype=np.uint8)
