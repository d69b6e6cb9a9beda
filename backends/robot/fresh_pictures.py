"""Pictures of a camera with its pose, and detection of an old picture returned for a new one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .robot_errors import StaleReading

STALE_PICTURE_MOTION = 1e-3  # [m], [rad] of motion in which a picture can't stay the same to the last bit


class Photo(NamedTuple):
    """A picture with the camera model and the camera's pose at the instant when the picture was taken."""

    pixels: ByteArray
    """Picture (height, width), grey, 0 to 255."""
    camera: CameraModel
    """Intrinsics and distortion, as calibrated."""
    base_T_camera: Transform
    """Pose (4, 4) of the optical frame (z forward, x right, y down) in the base frame, by the measured
    joints.
    """
    time: float
    """The robot's time, in [s]."""


class FreshPictures:
    """Detector of a camera that delivers an old picture again although the camera has moved.

    The camera's motion follows from the wheels and joints that carry it; `note` and `take` get the positions
    of those wheels and joints as an array (k,), in [m] or [rad].
    """

    def __init__(self) -> None:
        """Begin without a picture."""
        self._last: ByteArray | None = None
        self._taken_at = np.empty(0)
        self._moved = False  # since that picture, even if it is back

    @property
    def last(self) -> ByteArray | None:
        """The last picture (height, width), grey, 0 to 255; None before the first."""
        return self._last

    @property
    def awaits_motion(self) -> bool:
        """True if the camera has not moved since it took the picture that `last` returns."""
        return self._last is not None and not self._moved

    def note(self, carrier: FloatArray) -> None:
        """Record, once a period, the positions of the wheels and joints that carry the camera.

        Args:
            carrier: (k,) travel of the wheels in [m] and joints in [rad] or [m]; k must not change.
        """
        self._moved = self._is_away(carrier)

    def take(self, image: ByteArray, carrier: FloatArray, noisy: bool) -> ByteArray:
        """Accept a new picture and return it; raise if it equals the previous picture although the camera has
        moved.

        Args:
            image: (h, w), grey, 0 to 255.
            carrier: (k,) positions of the wheels and joints that carry the camera: travel in [m], joints in
                [rad] or [m].
            noisy: True if no two pictures taken at one pose are the same.

        Raises:
            StaleReading: all pixels equal those of the previous picture, although the camera has moved since.
        """
        same = self._last is not None and np.array_equal(image, self._last)
        if same and (self._moved if noisy else self._is_away(carrier)):
            raise StaleReading("the camera gives its last picture again, although it has moved")
        self._last, self._taken_at, self._moved = image, carrier, False
        return image

    def _is_away(self, carrier: FloatArray) -> bool:
        return bool(np.abs(carrier - self._taken_at).max() > STALE_PICTURE_MOTION)
