"""A camera with its place on the hand: as it should be, as it was calibrated, as it truly is."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.backends.description.sensor_specs import CalibratedCamera, CameraSpec
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.perception.cameras.camera_model import CameraModel


class MountedCamera(NamedTuple):
    """A camera on the hand."""

    model: CameraModel
    hand_T_camera: Transform
    """(4, 4) of the optical frame: z forward, x right, y down."""


def camera_model(spec: CameraSpec) -> CameraModel:
    """Return the model as stated: by a `camera_info` file, or with its axis through the picture's middle."""
    if spec.info is not None:
        return spec.info.model
    middle = (spec.width_px - 1) / 2, (spec.height_px - 1) / 2
    return _model(spec, spec, middle)


def stated_camera(spec: CameraSpec, arm: ArmModel) -> MountedCamera:
    """The camera as the robot's file and its URDF have it, without what a calibration found."""
    straight = np.zeros(arm.dof)
    hand_T_camera = inverse(arm.forward(straight)) @ arm.forward(straight, "camera")
    return MountedCamera(camera_model(spec), hand_T_camera)


def known_camera(spec: CameraSpec, arm: ArmModel) -> MountedCamera:
    """Return the camera as the robot knows it: calibrated if a calibration was made, otherwise as stated."""
    stated, found = stated_camera(spec, arm), spec.calibrated
    if found is None:
        return stated
    model = _model(spec, found, (found.cx_px, found.cy_px))
    return MountedCamera(model, stated.hand_T_camera @ correction(found))


def correction(found: CalibratedCamera) -> Transform:
    """Pose (4, 4) of the calibrated camera in the URDF's frame `camera`."""
    return transform(
        [each / 1e3 for each in found.xyz_mm],
        [math.radians(each) for each in found.rpy_deg],
    )


def _model(spec: CameraSpec, lens: CameraSpec | CalibratedCamera, centre: tuple[float, float]) -> CameraModel:
    focal = lens.focal_px
    K = np.array([[focal, 0.0, centre[0]], [0.0, focal, centre[1]], [0.0, 0.0, 1.0]])
    distortion = np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3])
    return CameraModel(K, distortion, spec.width_px, spec.height_px)
