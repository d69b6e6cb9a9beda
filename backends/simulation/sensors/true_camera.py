"""The camera as it truly is: not quite as the robot's file and its URDF have it."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.description.simulated_errors import Errors
from handcart.backends.robot.mounted_camera import CameraMount, MountedCamera, stated_camera
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.geometry.transform import Transform


def true_camera(spec: CameraSpec, mount: CameraMount, errors: Errors, seed: int) -> MountedCamera:
    """Return the true lens and mounting of a simulated camera, with errors drawn once for a seed.

    A calibration by the robot does not change them. Only simulation and evaluation may call this function.

    Args:
        spec: section of the camera in the robot's file.
        mount: place of the camera by the URDF.
        errors: standard deviations of the errors of mount and focal length.
        seed: seed of the errors.
    """
    stated, off = stated_camera(spec, mount), mount_error(errors, seed)
    longer = 1.0 + errors.focal_percent / 100.0 * float(keyed(seed, "focal length").standard_normal())
    K = stated.model.K * np.array([[longer, 1.0, 1.0], [1.0, longer, 1.0], [1.0, 1.0, 1.0]])
    return MountedCamera(stated.model._replace(K=K), stated.carrier_T_camera @ off, mount.carrier)


def mount_error(errors: Errors, seed: int) -> Transform:
    """Return the pose (4, 4) of the true optical frame in the optical frame that the robot's file states,
    drawn once for a seed.

    Args:
        errors: standard deviations of the errors of the mount.
        seed: seed of the draw.
    """
    shift, turn = keyed(seed, "camera mount").standard_normal((2, 3))
    off = np.eye(4)
    off[:3, 3] = errors.camera_mount_mm / 1e3 * shift
    off[:3, :3] = Rotation.from_rotvec(errors.camera_mount_mrad / 1e3 * turn).as_matrix()
    return off
