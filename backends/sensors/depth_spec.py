"""Depth camera in a robot's file."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from typing_extensions import override

from handcart.backends.description.sensor_spec import Carrier, MountedSensorSpec
from handcart.files.models.model import FileModel
from handcart.robotics.perception.cameras.camera_model import CameraModel

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Percent = Annotated[float, Field(ge=0.0, le=100.0)]
Side = Annotated[int, Field(ge=8, le=4096)]


class DepthErrors(FileModel):
    """Errors of a depth camera. The defaults are those of a camera with structured light.

    The standard deviation of a depth z is `sigma_mm` + `sigma_mm_per_m2` (z - `sigma_from_m`)^2, as measured
    by Nguyen, Izadi and Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and tracking"
    (2012), eq. 3.
    """

    sigma_mm: NotNegative = 1.2
    """Sigma of a depth at `sigma_from_m`, and nearer."""
    sigma_mm_per_m2: NotNegative = 1.9
    """Growth of the sigma with the square of the distance beyond `sigma_from_m`."""
    sigma_from_m: NotNegative = 0.4
    scale_percent: NotNegative = 0.5
    """Sigma of the scale error common to all depths, constant in time."""
    dropout_percent: Percent = 0.5
    """Share of pixels without a reading, each pixel and period for itself."""
    edge_px: Annotated[int, Field(ge=0, le=50)] = 2
    """Distance from a step in depth within which pixels have no reading."""
    edge_step_percent: Positive = 5.0
    """Difference between neighbouring depths that is a step, relative to the nearer one."""
    grazing_deg: Annotated[float, Field(gt=0.0, le=90.0)] = 75.0
    """Angle between a pixel's ray and the surface's normal beyond which a pixel has no reading."""

    @classmethod
    def exact(cls) -> Self:
        """Return the errors of a perfect depth camera: no noise, and a depth for every pixel."""
        return cls(
            sigma_mm=0.0,
            sigma_mm_per_m2=0.0,
            scale_percent=0.0,
            dropout_percent=0.0,
            edge_px=0,
            grazing_deg=90.0,
        )


class DepthCameraSpec(MountedSensorSpec):
    """Description of a depth camera. Its colour and depth pictures are rectified and have the same viewpoint.

    The camera's frame in the URDF is the optical frame (z forward, x right, y down).
    """

    CARRIER: ClassVar[Carrier | None] = "any"
    kind: Literal["depth_camera"] = "depth_camera"
    width_px: Side
    height_px: Side
    focal_px: Positive
    range_min_m: NotNegative = 0.3
    """Minimum depth; something nearer has no reading."""
    reach_m: Positive = 6.0
    """Maximum depth; something farther has no reading."""
    errors: DepthErrors = DepthErrors()

    @model_validator(mode="after")
    def _has_range(self) -> Self:
        if self.range_min_m >= self.reach_m:
            wrong = f"range_min_m {self.range_min_m:g}"
            raise ValueError(f"{wrong}; allowed: less than {self.reach_m:g}, the reach")
        return self

    @override
    def without_errors(self) -> Self:
        return self.model_copy(update={"errors": DepthErrors.exact()})

    @property
    def model(self) -> CameraModel:
        """Pinhole model of the colour and depth pictures, with the optical axis in their middle."""
        centre = (self.width_px - 1) / 2, (self.height_px - 1) / 2
        K = np.array([[self.focal_px, 0.0, centre[0]], [0.0, self.focal_px, centre[1]], [0.0, 0.0, 1.0]])
        return CameraModel(K, np.zeros(5), self.width_px, self.height_px)
