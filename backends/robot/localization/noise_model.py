"""Assumed errors of wheels, gyros and receiver outdoors, from the robot's file."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.beacons.beacon_errors import BeaconErrors
from handcart.robotics.navigation.beacons.beacon_filter import BeaconFilter
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE, FieldNoise
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.gyro_only import GyroOnly
from handcart.robotics.navigation.outdoors.particle_filter import ParticleErrors, ParticleFilter

if TYPE_CHECKING:
    from handcart.backends.description.beacons_spec import BeaconsSpec
    from handcart.backends.description.ground_spec import GpsSpec
    from handcart.backends.description.robot_file import RobotFile

START_SIGMA_M = 0.05  # [m] an axis: how well a task says where the robot starts
LEAST_GPS = 0.003  # [m]: a receiver without errors is believed no better
LEAST_RANGE = 0.005  # [m]: nor are beacons
LEAST_GYRO = math.radians(1e-4)  # [rad/√s]


def field_noise(robot: RobotFile, antenna: tuple[float, float, float]) -> FieldNoise:
    """Return the outdoor errors of a robot's wheels, gyros and satellite receiver, in SI units.

    Args:
        robot: robot file, which states the errors.
        antenna: position of the satellite receiver's antenna in the base frame, in [m].
    """
    ground, gps, imu = robot.ground, robot.gps, robot.imu
    noise = REFERENCE_NOISE._replace(
        roughness=math.radians(ground.roughness_deg),
        roughness_length=ground.roughness_length_m,
        scale=ground.scale_percent / 100,
        slip=ground.slip_percent / 100,
        slip_length=ground.slip_length_m,
        turn_slip=ground.turn_slip_percent / 100,
        side_slip=math.radians(ground.side_slip_deg),
        side_slip_length=ground.side_slip_length_m,
        side_slip_turning=math.radians(ground.side_slip_deg_m),
        antenna=antenna,
    )
    if gps is not None:
        noise = noise._replace(
            gps_period=gps.period_s,
            gps_white=max(LEAST_GPS, gps.white_m),
            gps_drift=gps.drift_m,
            gps_drift_time=gps.drift_time_s,
            start_heading=_start_heading(gps),
        )
    if imu is not None:
        noise = noise._replace(
            gyro_white=max(LEAST_GYRO, math.radians(imu.angle_random_walk_deg_rt_s)),
            gyro_walk=math.radians(imu.rate_random_walk_deg_s_rt_s),
            gyro_bias=math.radians(imu.gyro_bias_deg_s),
            gyro_warm_up=math.radians(imu.warm_up_deg_s),
            gyro_warm_up_time=imu.warm_up_s,
            gyro_scale=imu.gyro_scale_percent / 100,
            accelerometer_white=imu.accelerometer_sigma_m_s2,
            accelerometer_bias=imu.accelerometer_bias_m_s2,
            vibration=imu.vibration_m_s2,
        )
    return noise


def _start_heading(gps: GpsSpec) -> float:
    """Return sigma of the start heading in [rad]; infinite if it is unknown."""
    given = gps.start_heading_deg
    return math.inf if isinstance(given, str) else math.radians(given)


def beacon_errors(beacons: BeaconsSpec) -> BeaconErrors:
    """Return the beacons' positions and the assumed errors of their ranges, in SI units."""
    return BeaconErrors(
        np.array(list(beacons.places_m.values())),
        beacons.tag_m,
        max(LEAST_RANGE, beacons.sigma_m),
        max(LEAST_RANGE, beacons.bias_m),
        beacons.scale_percent / 100,
        beacons.bias_walk_m_rt_s,
    )


def field_localizer(robot: RobotFile, start: Pose2, antenna: tuple[float, float, float]) -> FieldLocalizer:
    """Create the outdoor localizer that the key `localizer` of a robot's file names.

    Args:
        robot: robot file.
        start: initial world_T_base.
        antenna: position of the satellite receiver's antenna in the base frame, in [m].
    """
    noise = field_noise(robot, antenna)
    if math.isinf(noise.start_heading):
        start = Pose2(start.x, start.y, 0.0)
    if robot.localizer == "gps_filter":
        return GpsFilter(start, noise, START_SIGMA_M, record=True)
    if robot.localizer == "beacons":
        assert robot.beacons is not None, "checked when the file was read"
        return BeaconFilter(start, noise, beacon_errors(robot.beacons), START_SIGMA_M)
    if robot.localizer == "particle":
        errors = ParticleErrors(gps=max(noise.gps_white, 0.05), start_heading=noise.start_heading)
        return ParticleFilter(start, errors)
    return GyroOnly(start, noise, START_SIGMA_M)
