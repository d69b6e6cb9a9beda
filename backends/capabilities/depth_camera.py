"""Depth cameras."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, apply
from handcart.robotics.numerics.arrays import ByteArray, FloatArray, SingleArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .capability import Capability, Reading


class DepthImage(NamedTuple):
    """Colour and depth picture taken at one instant, with the camera's pose at that instant."""

    colour: ByteArray
    """Colours (height, width, 3) in RGB, 0 to 255."""
    depth: SingleArray
    """Depths (height, width) in [m] along the optical axis; NaN without a reading."""
    base_T_camera: Transform
    """Pose (4, 4) of the optical frame (z forward, x right, y down) in the base frame, by the joints measured
    at that time.
    """
    time: float
    """Time of the picture in [s], counted in periods of the backend since it was built."""

    def points(self, model: CameraModel) -> FloatArray:
        """Return the points (n, 3) of the pixels that have a reading, row by row, in the base frame, in [m].

        Args:
            model: intrinsics and distortion of the camera.
        """
        rows, columns = np.nonzero(np.isfinite(self.depth))
        z = self.depth[rows, columns].astype(np.float64)
        rays = model.undistort(np.column_stack((columns, rows)).astype(np.float64))
        return apply(self.base_T_camera, np.column_stack((rays * z[:, None], z)))


class DepthCamera(Capability):
    """A camera that measures colour and depth through one lens; its pictures are rectified."""

    READINGS: ClassVar = {"image": Reading("depth camera", ("colour", "depth"), noisy=True)}

    @abstractmethod
    def image(self) -> DepthImage:
        """Return the camera's picture of this period, with colours and depths."""

    @property
    @abstractmethod
    def model(self) -> CameraModel:
        """Camera model (intrinsics) that applies to the colour picture and the depth picture."""
