"""Difference between a calibrated camera and the camera that takes the pictures, by the ground truth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CalibratedCamera, CameraSpec
from handcart.backends.robot.mounted_camera import MountedCamera, known_camera, mount_of
from handcart.backends.simulation.noise.keyed_noise import sensor_seed
from handcart.backends.simulation.sensors.true_camera import true_camera
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.robotics.geometry.transform import apply, difference
from handcart.robotics.numerics.arrays import FloatArray

VIEW_DISTANCE_M = 0.3  # [m] from the camera, where blocks and landmarks are looked at
_COLUMNS, _ROWS = 17, 13


def camera_figures(
    robot: RobotFile, spec: CameraSpec, seed: int, found: Mapping[str, Calibrated]
) -> dict[str, float]:
    """Return errors of the camera's mounting, and of points located by the camera, before and after its
    calibration, as run metrics.

    Args:
        robot: robot as it was in the run.
        spec: section of the camera on the robot's hand.
        seed: seed of the run.
        found: results of the run's calibration, by key.
    """
    mount, name = mount_of(robot, spec), robot.name_of(spec)
    true = true_camera(spec, mount, robot.errors, sensor_seed(seed, name))
    start = ".".join((*robot.key_of(name), "calibrated", ""))
    after = {
        key.removeprefix(start): calibrated_.value
        for key, calibrated_ in found.items()
        if key.startswith(start)
    }
    calibrated = spec.model_copy(update={"calibrated": CalibratedCamera.model_validate(after)})
    figures: dict[str, float] = {}
    for name, camera in (("before", known_camera(spec, mount)), ("after", known_camera(calibrated, mount))):
        off = 1e3 * np.linalg.norm(_points(camera) - _points(true), axis=1)
        far, turned = difference(camera.hand_T_camera, true.hand_T_camera)
        figures |= {
            f"mount_error_{name}_mm": round(1e3 * far, 3),
            f"mount_error_{name}_mrad": round(1e3 * turned, 3),
            f"point_error_{name}_mm_mean": round(float(off.mean()), 3),
            f"point_error_{name}_mm_max": round(float(off.max()), 3),
        }
    return figures


def _points(camera: MountedCamera) -> FloatArray:
    """Return (n, 3) points in the hand frame in [m] that pixels of the picture show on a plane in front of
    the camera.
    """
    model = camera.model
    columns, rows = np.meshgrid(
        np.linspace(0, model.width - 1, _COLUMNS), np.linspace(0, model.height - 1, _ROWS)
    )
    rays = model.undistort(np.column_stack([columns.ravel(), rows.ravel()]))
    return apply(camera.hand_T_camera, VIEW_DISTANCE_M * np.column_stack([rays, np.ones(len(rays))]))
