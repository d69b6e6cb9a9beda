"""A camera with its place on the robot: as it should be, as it was calibrated, as it truly is."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CalibratedCamera, CameraSpec
from handcart.files.errors import HandcartError
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.urdf_mounts import joints_between
from handcart.robotics.perception.cameras.camera_model import CameraModel

HAND_LINK = "hand"


class NotOnHand(HandcartError, ValueError):
    """Error: the pose of a camera in the hand frame is needed, but the camera is not fixed on the hand."""


class CameraMount(NamedTuple):
    """Mounting pose of a camera, by the URDF, on a link whose pose is known from the joints."""

    carrier: str
    """Link that carries the camera: the hand, or the camera's own link."""
    carrier_T_frame: Transform
    """Pose (4, 4) of the camera's frame of the URDF in the frame of the link `carrier`."""


class MountedCamera(NamedTuple):
    """Intrinsics of a camera, and its mounting pose on the hand or elsewhere on the robot."""

    model: CameraModel
    carrier_T_camera: Transform
    """Pose (4, 4) of the optical frame (z forward, x right, y down) in the frame of the link `carrier`."""
    carrier: str = HAND_LINK
    """Link that carries the camera: the hand, or the camera's own link."""

    @property
    def hand_T_camera(self) -> Transform:
        """Pose (4, 4) of the optical frame (z forward, x right, y down) in the hand frame.

        Raises:
            NotOnHand: the hand does not carry the camera.
        """
        if self.carrier != HAND_LINK:
            raise NotOnHand(f"the camera is at the link {self.carrier!r}; needed: one on the hand")
        return self.carrier_T_camera


def camera_mount(robot: RobotFile, link: str, arm: ArmModel | None) -> CameraMount:
    """Return the mount of a camera at a link of the URDF; the camera is on the hand if no joint is between
    the hand and that link.

    Args:
        robot: robot file.
        link: frame of the camera.
        arm: kinematics of the arm; None without one.
    """
    if arm is None or joints_between(robot.urdf_text(), link, HAND_LINK):
        return CameraMount(link, np.eye(4))
    return hand_mount(arm, link)


def mount_of(robot: RobotFile, camera: CameraSpec, arm: ArmModel | None = None) -> CameraMount:
    """Return the mount of one of a robot's cameras.

    Args:
        robot: robot file.
        camera: section of the camera in that file.
        arm: model of the robot's arm; None: it is built again, which takes time.
    """
    if arm is None and robot.arm is not None:
        arm = robot.arm_model()
    return camera_mount(robot, robot.link_of(camera), arm)


def hand_mount(arm: ArmModel, link: str = "camera") -> CameraMount:
    """Return the mount of a camera that is fixed on the hand of an arm; `link` is the camera's link in the
    arm's model.
    """
    straight = np.zeros(arm.dof)
    return CameraMount(HAND_LINK, inverse(arm.forward(straight)) @ arm.forward(straight, link))


def camera_model(spec: CameraSpec) -> CameraModel:
    """Return the nominal model of a camera, without its calibration.

    The model is read from the `camera_info` file. Without this file, the optical axis is in the middle of the
    picture.
    """
    if spec.info is not None:
        return spec.info.model
    middle = (spec.width_px - 1) / 2, (spec.height_px - 1) / 2
    return _model(spec, spec, middle)


def stated_camera(spec: CameraSpec, mount: CameraMount) -> MountedCamera:
    """Return a camera with the nominal intrinsics and mounting pose of the robot's file and URDF, not the
    calibrated ones.
    """
    return MountedCamera(camera_model(spec), mount.carrier_T_frame, mount.carrier)


def known_camera(spec: CameraSpec, mount: CameraMount) -> MountedCamera:
    """Return the camera that the robot uses: the calibrated one, or the nominal one without a calibration."""
    stated, found = stated_camera(spec, mount), spec.calibrated
    if found is None:
        return stated
    model = _model(spec, found, (found.cx_px, found.cy_px))
    return MountedCamera(model, stated.carrier_T_camera @ correction(found), mount.carrier)


def correction(found: CalibratedCamera) -> Transform:
    """Return the pose (4, 4) of the calibrated optical frame in the camera's frame of the URDF."""
    return transform(
        [value / 1e3 for value in found.xyz_mm],
        [math.radians(value) for value in found.rpy_deg],
    )


def _model(spec: CameraSpec, lens: CameraSpec | CalibratedCamera, centre: tuple[float, float]) -> CameraModel:
    focal = lens.focal_px
    K = np.array([[focal, 0.0, centre[0]], [0.0, focal, centre[1]], [0.0, 0.0, 1.0]])
    distortion = np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3])
    return CameraModel(K, distortion, spec.width_px, spec.height_px)
