"""Cameras."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .capability import Capability, Reading


class Camera(Capability):
    """A grey camera, on the hand or elsewhere on the robot."""

    READINGS: ClassVar = {"image": Reading("camera", noisy=True)}

    @abstractmethod
    def image(self) -> ByteArray:
        """Return this period's picture (height, width), grey, from 0 to 255.

        It has the lens's distortion and the sensor's noise.
        """

    @property
    @abstractmethod
    def model(self) -> CameraModel:
        """Intrinsics and distortion, as calibrated."""

    @property
    @abstractmethod
    def hand_T_camera(self) -> Transform:
        """Pose (4, 4) of the optical frame (z forward, x right, y down) in the hand frame, as calibrated.

        Raises:
            NotOnHand: the hand does not carry the camera.
        """

    @property
    def carrier(self) -> str:
        """Link that carries the camera: its pose follows from the measured joints."""
        return "hand"

    @property
    def carrier_T_camera(self) -> Transform:
        """Pose (4, 4) of the optical frame in the frame of the link `carrier`, as calibrated."""
        return self.hand_T_camera
