"""Cameras."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from typing import ClassVar, TypeVar

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .capability import Capability, Reading

CapabilityT = TypeVar("CapabilityT", bound=Capability)
HAND_LINK = "hand"


class AnyCamera(Capability):
    """A camera anywhere on the robot whose pose follows from the measured joints.

    A primitive that requires a `Camera` needs a camera on the hand; a primitive that requires `AnyCamera`
    also works with a camera on a head or on a mast.
    """


class Camera(AnyCamera):
    """A grey camera, on the hand or elsewhere on the robot."""

    READINGS: ClassVar = {"image": Reading("camera", noisy=True)}

    @abstractmethod
    def image(self) -> ByteArray:
        """Return this period's picture (height, width), grey, from 0 to 255.

        The picture has the lens's distortion and the sensor's noise.
        """

    @property
    @abstractmethod
    def model(self) -> CameraModel:
        """Intrinsics and distortion, calibrated if there is a calibration."""

    @property
    @abstractmethod
    def hand_T_camera(self) -> Transform:
        """Pose (4, 4) of the optical frame (z forward, x right, y down) in the hand frame, by calibration if
        there is one.

        Raises:
            NotOnHand: the hand does not carry the camera.
        """

    @property
    def carrier(self) -> str:
        """Link that carries the camera; the link's pose follows from the measured joints."""
        return "hand"

    @property
    def carrier_T_camera(self) -> Transform:
        """Pose (4, 4) of the optical frame in the frame of the link `carrier`, by calibration if there is
        one.
        """
        return self.hand_T_camera


def camera_of_kind(capabilities: Iterable[Capability], kind: type[CapabilityT]) -> CapabilityT | None:
    """Return the camera of the class `kind` that is on the hand.

    If no camera is on the hand: the first camera elsewhere on the robot for the class `AnyCamera`, None for
    any other class.
    """
    cameras = [capability for capability in capabilities if isinstance(capability, kind)]
    on_hand = next((camera for camera in cameras if getattr(camera, "carrier", "") == HAND_LINK), None)
    return next(iter(cameras), None) if on_hand is None and kind is AnyCamera else on_hand


def usable_kinds(capabilities: Iterable[Capability]) -> list[type[Capability]]:
    """Return the classes under which a robot's capabilities are available to primitives.

    A camera that is not on the hand appears as `AnyCamera`; other sensors on a link that is not the hand are
    skipped.
    """
    kinds: list[type[Capability]] = []
    for capability in capabilities:
        if getattr(capability, "carrier", HAND_LINK) == HAND_LINK:
            kinds.append(type(capability))
        elif isinstance(capability, Camera):
            kinds.append(AnyCamera)
    return kinds
