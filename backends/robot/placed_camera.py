"""Base class of cameras that a robot's file places and a calibration corrects."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.capabilities.camera import Camera
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .mounted_camera import MountedCamera


class PlacedCamera(Camera):
    """Base class of cameras whose lens and mounting pose are known (`MountedCamera`).

    A subclass adds the method that takes the pictures.
    """

    _known: MountedCamera
    """The camera as it was calibrated."""

    @property
    @override
    def model(self) -> CameraModel:
        return self._known.model

    @property
    @override
    def hand_T_camera(self) -> Transform:
        return self._known.hand_T_camera.copy()

    @property
    @override
    def carrier(self) -> str:
        return self._known.carrier

    @property
    @override
    def carrier_T_camera(self) -> Transform:
        return self._known.carrier_T_camera.copy()
