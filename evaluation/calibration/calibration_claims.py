"""Check the results that a calibration claims, with their sigmas."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.mounted_camera import mount_of, stated_camera
from handcart.backends.simulation.noise.keyed_noise import sensor_seed
from handcart.backends.simulation.sensors.true_camera import true_camera
from handcart.evaluation.judging.sensor_sigmas import LIMIT_SIGMAS
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.robotics.geometry.transform import inverse

FOCAL_SHARE = 0.002  # by which the focal length trades with distance, unseen by its sigma
MIDDLE_PX = 2.0  # the same of the picture's middle, against the mount
MAX_LENS_ERRORS = {"k1": 0.02, "k2": 0.1}  # the same of the lens
ARM_MRAD = 2.0  # by which an arm's own errors turn a mount
MAX_SPOT_ERRORS = {"yaw_mrad_per_swing": 0.15, "roll_mrad_per_m": 1.5, "pitch_mrad_per_m": 1.5}
"""Allowed error of laser spots on a wall, read with a ruler."""
FIXED_SHARE = 2.5  # fixed limit of a calibration's error in the figures above, however large its sigma


def camera_faults(robot: RobotFile, seed: int, found: Mapping[str, Calibrated]) -> list[str]:
    """Return a message for each calibrated camera parameter with too large a true error.

    An error is too large above 5 sigma, or above a fixed limit of the parameter.

    Args:
        robot: robot as it was in the run.
        seed: seed of the run.
        found: results of the run's calibration, by key.
    """
    camera = robot.hand_camera
    assert camera is not None
    assert robot.arm is not None
    mount_stated = mount_of(robot, camera)
    true = true_camera(camera, mount_stated, robot.errors, sensor_seed(seed, robot.name_of(camera)))
    stated = stated_camera(camera, mount_stated)
    off = inverse(stated.hand_T_camera) @ true.hand_T_camera
    K, lens = true.model.K, true.model.distortion
    mount = LIMIT_SIGMAS * robot.arm.accuracy_mm
    truth: dict[str, tuple[object, float]] = {
        "focal_px": (K[1, 1], FOCAL_SHARE * K[1, 1]),
        "cx_px": (K[0, 2], MIDDLE_PX),
        "cy_px": (K[1, 2], MIDDLE_PX),
        "k1": (lens[0], MAX_LENS_ERRORS["k1"]),
        "k2": (lens[1], MAX_LENS_ERRORS["k2"]),
        "xyz_mm": (1e3 * off[:3, 3], mount),
        "rpy_deg": (
            Rotation.from_matrix(off[:3, :3]).as_euler("xyz", degrees=True),
            np.degrees(LIMIT_SIGMAS * ARM_MRAD / 1e3),
        ),
    }
    return _beyond(found, truth)


def suspension_faults(spots: Mapping[str, float], found: Mapping[str, Calibrated]) -> list[str]:
    """Return a message for each calibrated suspension parameter that contradicts the laser measurement.

    A parameter may differ from the measurement by the error of reading the laser spots plus 5 sigma of the
    calibration, but not by more than a fixed limit.

    Args:
        spots: results of a `LaserSurvey`, a simulated person who reads laser spots on walls, by name.
        found: results of the run's calibration, by key.
    """
    return _beyond(found, {name: (spots[f"laser_{name}"], most) for name, most in MAX_SPOT_ERRORS.items()})


def _beyond(found: Mapping[str, Calibrated], truth: Mapping[str, tuple[object, float]]) -> list[str]:
    wrong = []
    for key, (value, sigma) in found.items():
        name = key.rpartition(".")[2]
        if name not in truth:
            continue
        true, room = truth[name]
        off = np.abs(np.atleast_1d(np.asarray(value) - np.asarray(true)))
        most = np.minimum(room + LIMIT_SIGMAS * np.atleast_1d(np.asarray(sigma)), FIXED_SHARE * room)
        wrong += [
            f"{name} is {size:.3g} off (at most {limit:.3g})"
            for size, limit in zip(off.tolist(), most.tolist(), strict=True)
            if not size <= limit
        ]
    return wrong
