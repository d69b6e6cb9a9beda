"""Sensors in a robot's file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator
from typing_extensions import override

from handcart.files.errors import UnsafePath
from handcart.files.inside import FilePath, resolve_inside
from handcart.files.models.model import FileModel
from handcart.robotics.navigation.odometry.odometry import OdometryErrors, SidewaysErrors

from .camera_info import CameraInfo, load_camera_info
from .range_spec import RangeSpec as RangeSpec
from .sensor_spec import Carrier, MountedSensorSpec, SensorSpec, UnreadableFile

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


class OdometrySpec(FileModel):
    """Standard deviations (sigmas) of the wheel odometry's errors, as the localizer assumes them.

    The true errors of simulated wheels are in the section `errors`. The defaults are for uncalibrated wheels.
    If only the wheels determine the pose, the pose's covariance is only as good as these values.
    """

    wheel_radius_percent: Positive = 2.0
    """Sigma of each wheel's radius, constant in time."""
    tread_percent: Positive = 2.0
    """Sigma of the distance between the wheels, constant in time."""
    slip_percent: Positive = 2.0
    """Sigma of the slip of each wheel's travel, independent every `slip_length_m`."""
    slip_length_m: Positive = 0.1
    sideways_percent: Positive = 5.0
    """`holonomic`: sigma of the distance driven sideways, and of the motion ahead that goes with it, constant
    in time.
    """
    sideways_turn_deg_per_m: Positive = 3.0
    """`holonomic`: sigma of the turn that goes with each metre sideways, constant in time."""
    sideways_slip_percent: Positive = 4.0
    """`holonomic`: sigma of the slip sideways, independent every `slip_length_m`."""

    @property
    def sideways_errors(self) -> SidewaysErrors:
        """Sigmas of the errors of sideways travel: scale and slip as ratios of the travel, and the base's
        turn in [rad] per metre of travel.
        """
        return SidewaysErrors(
            self.sideways_percent / 100,
            math.radians(self.sideways_turn_deg_per_m),
            self.sideways_slip_percent / 100,
        )

    @property
    def errors(self) -> OdometryErrors:
        """Standard deviations of the wheel odometry's errors, as ratios of wheel radius, tread and travel,
        and the distance in [m] after which the slip changes.
        """
        return OdometryErrors(
            self.wheel_radius_percent / 100,
            self.tread_percent / 100,
            self.slip_percent / 100,
            self.slip_length_m,
        )


class CalibratedCamera(FileModel):
    """Measured calibration of a camera (`tasks/calibrate_camera`): focal length, centre, lens and mount.

    It replaces the nominal values of the camera.
    """

    focal_px: Positive
    cx_px: float
    """Column of the picture's centre, where the optical axis meets it; an integer is a pixel's middle."""
    cy_px: float
    """Row of the picture's centre, where the optical axis meets it."""
    k1: float = 0.0
    """Lens coefficient; all follow Brown's model as in OpenCV and ROS (`plumb_bob`)."""
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0
    xyz_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Offset of the camera from the URDF's frame `camera`, along the axes of that frame."""
    rpy_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Orientation of the camera in the URDF's frame `camera`: roll, pitch, yaw."""


class CameraSpec(MountedSensorSpec):
    """Picture size, focal length and lens of a camera, and its calibration if there is one.

    Without `camera_info` and calibration, the optical axis is in the middle of the picture.
    """

    CARRIER: ClassVar[Carrier | None] = "any"
    kind: Literal["camera"] = "camera"
    camera_info: FilePath | None = None
    """A YAML file of ROS beside the robot's file, instead of size, focal length and lens."""
    width_px: Annotated[int, Field(ge=0)] = 0
    height_px: Annotated[int, Field(ge=0)] = 0
    focal_px: NotNegative = 0.0
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0
    calibrated: CalibratedCamera | None = None
    """Measured calibration, if any."""
    _info: CameraInfo | None = None

    @model_validator(mode="after")
    def _has_one_lens(self) -> Self:
        sizes = {"width_px", "height_px", "focal_px"}
        lens = sizes | {"k1", "k2", "p1", "p2", "k3"}
        if self.camera_info is None and (
            missing := [name for name in sorted(sizes) if not getattr(self, name)]
        ):
            raise ValueError(f"no {', no '.join(missing)}; needed: numbers above 0, or the key camera_info")
        if self.camera_info is not None and (also := sorted(lens & self.model_fields_set)):
            raise ValueError(f"camera_info and {', '.join(also)}; allowed: camera_info, which has them")
        return self

    @override
    def with_files(self, folder: Path) -> Self:
        if self.camera_info is None:
            return self
        try:
            path = resolve_inside(folder, self.camera_info)
        except UnsafePath as unsafe:
            raise UnreadableFile("camera_info", str(unsafe)) from None
        if not path.is_file():
            wrong = f"missing file {self.camera_info!r}; allowed: one beside the robot's file"
            raise UnreadableFile("camera_info", wrong)
        return self.with_info(load_camera_info(path))

    @property
    def info(self) -> CameraInfo | None:
        """Intrinsics of the camera from the file that the key `camera_info` names; None without this key."""
        return self._info

    def with_info(self, info: CameraInfo) -> Self:
        """Return a copy with the picture size, focal length and lens of a `camera_info` file."""
        K = info.K
        size = {"width_px": info.image_width, "height_px": info.image_height, "focal_px": float(K[0, 0])}
        camera = self.model_copy(update=size)
        camera._info = info
        return camera


class ImuSpec(MountedSensorSpec):
    """Description of an IMU and its errors; its axes are parallel to those of the base."""

    kind: Literal["imu"] = "imu"

    angle_random_walk_deg_rt_s: NotNegative
    """White noise of the gyros, in degrees after a second; it grows with the square root of time."""
    gyro_bias_deg_s: NotNegative = 0.0
    """Sigma of the gyros' bias, their reading at rest."""
    rate_random_walk_deg_s_rt_s: NotNegative = 0.0
    """Random walk of the gyro's bias after one second; it grows with the square root of time."""
    warm_up_deg_s: NotNegative = 0.0
    """Sigma of the part of the gyros' bias that decays while they warm up."""
    warm_up_s: Positive = 600.0
    """Duration of the warm-up drift."""
    gyro_scale_percent: NotNegative = 0.0
    """Sigma of a gyro's scale error, relative to the turn."""
    accelerometer_sigma_m_s2: NotNegative
    """Sigma of an accelerometer's reading."""
    accelerometer_bias_m_s2: NotNegative = 0.0
    """Sigma of each accelerometer's bias."""
    vibration_m_s2: NotNegative = 0.0
    """Additional sigma of an accelerometer's reading while the base drives."""

    @override
    def without_errors(self) -> Self:
        return type(self)(frame=self.frame, angle_random_walk_deg_rt_s=0.0, accelerometer_sigma_m_s2=0.0)


class PositioningSpec(SensorSpec):
    """Noise, rate and delay of an indoor positioning system's readings."""

    kind: Literal["positioning"] = "positioning"

    sigma_mm: NotNegative
    """Sigma of a reading, along each axis."""
    heading_sigma_mrad: NotNegative
    rate_hz: Positive
    """Readings a second; not more than periods."""
    latency_s: NotNegative = 0.0
    """Delay of a reading."""

    @override
    def without_errors(self) -> Self:
        return self.model_copy(update={"sigma_mm": 0.0, "heading_sigma_mrad": 0.0})
