"""Choice of a robot's localization, by its file and its backend's capabilities."""

from __future__ import annotations

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.missing_capability import MissingCapability
from handcart.backends.capabilities.positioning import Positioning
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.ground_spec import OUTDOOR_LOCALIZERS
from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import ScanLocalizer
from handcart.robotics.navigation.localization.odometry_localizer import OdometryLocalizer
from handcart.robotics.navigation.localization.positioning_localizer import PositioningLocalizer
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.odometry.odometry import OdometryErrors
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

from .localization import Localization
from .noise_model import field_localizer
from .outdoor_localization import OutdoorLocalization
from .positioning_localization import PositioningLocalization
from .scan_localization import ScanLocalization
from .wheel_localization import WheelLocalization

LEAST_RANGE = 0.01  # [m]: no range sensor is believed to be better
START_SIGMA = np.diag([0.05**2, 0.05**2, 0.035**2])  # [m², rad²] of where a task says the robot starts
EXACT_START = np.diag([0.002**2, 0.002**2, 0.001**2])  # the same where the start defines the frame


def localization_of(
    backend: Backend,
    spec: RobotFile,
    start: Pose2,
    grid: GridMap | None,
    lidar: RangeSensor | None,
    is_start_exact: bool = False,
) -> Localization:
    """Build the localization that the robot's file names, or a simpler one if its sensors are missing.

    Without a positioning system, scans are matched with the map instead; without a map or a lidar, only the
    wheels are used. The outdoor localizations need an IMU.

    Args:
        backend: backend of the robot, which is at rest.
        spec: robot file.
        start: map_T_base as the task states it.
        grid: map that scans are compared with; None without one.
        lidar: lidar whose scans are compared with the map; None without one.
        is_start_exact: True if the start defines the map frame, because there is no map.

    Raises:
        MissingCapability: the backend has no IMU, which an outdoor localization needs.
    """
    if spec.localizer in OUTDOOR_LOCALIZERS and backend.get(Imu) is None:  # type: ignore[type-abstract]
        needed_by = f"`localizer: {spec.localizer}` in the robot's file"
        raise MissingCapability(Imu, backend.capabilities(), needed_by)
    known = EXACT_START if is_start_exact else START_SIGMA
    tread, positioning, errors = spec.drive.tread_m, spec.positioning, odometry_errors(spec)
    if spec.localizer == "positioning" and positioning and backend.get(Positioning):  # type: ignore[type-abstract]
        sigma = positioning.sigma_mm / 1e3, positioning.heading_sigma_mrad / 1e3
        return PositioningLocalization(
            backend, PositioningLocalizer(start, tread, sigma, errors, known), lidar
        )
    noise = range_noise(spec)
    field = LikelihoodField(grid) if grid is not None and lidar is not None else None
    if field is not None and spec.localizer not in ("odometry", *OUTDOOR_LOCALIZERS):
        matching = ScanLocalizer(field, start, tread, errors, known, noise)
        return ScanLocalization(backend, matching, lidar)
    wheels = OdometryLocalizer(start, tread, errors, known, field, noise)
    if spec.localizer in OUTDOOR_LOCALIZERS:
        return OutdoorLocalization(backend, wheels, field_localizer(spec, start, spec.antenna), lidar)
    return WheelLocalization(backend, wheels, lidar)


def odometry_errors(spec: RobotFile) -> OdometryErrors:
    """Return the assumed errors of a robot's wheel odometry, including those of sideways motion for a
    holonomic base.
    """
    errors = spec.odometry.errors
    if spec.drive.kind != "holonomic":
        return errors
    return errors._replace(sideways=spec.odometry.sideways_errors)


def range_noise(spec: RobotFile) -> float:
    """Return the sigma of the lidar's ranges, in [m], that is assumed when scans are compared with a map."""
    return max(LEAST_RANGE, spec.range_sensor.sigma_mm / 1e3) if spec.range_sensor else LEAST_RANGE
