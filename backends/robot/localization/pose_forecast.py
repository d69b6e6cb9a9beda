"""Forecast of the accuracy of a robot's pose at the end of a route, by its map and its lidar."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.navigation.localization.localizer import ScanLocalizer
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.start_search import ScanBeams, map_ranges
from handcart.robotics.navigation.scans.surface_depth import depth_shifts
from handcart.robotics.numerics.arrays import FloatArray

from .determination import NO_SHIFT, PoseNeed, Undetermined, undetermined
from .lidar import MIN_ECHOES
from .localizations import START_SIGMA
from .pose_covariance import repeatability_of, worst_sigmas

MIN_STEP_M = 0.3  # between two scans of the forecast
MAX_SCANS = 100
MIN_RANGE_SIGMA_M = 0.01


class PoseForecast(NamedTuple):
    """Forecast, before a drive, of how accurately the localizer will know the base's pose at the end of the
    drive's route.
    """

    found: Undetermined | None
    """The direction in which the pose will not be determined as exactly as the place needs it; None if it
    will be in all.
    """
    blind_m: float
    """Length of the route, in [m], on which the pose isn't as exact as places usually need it."""
    route_m: float
    silent_m: float
    """Length of the route, in [m], on which the lidar gets nearly no echoes, so that wheels alone propagate
    the pose.
    """
    silent_at: Pose2 | None
    """map_T_base of the first pose with nearly no echoes; None without one."""
    silent_sigma_m: float
    """Largest sigma of the position on that part of the route, in its worst direction, in [m]."""


def forecast_pose(
    field: LikelihoodField,
    robot: RobotFile,
    lidar: RangeSpec,
    start: Pose2,
    route: FloatArray,
    need: PoseNeed,
    docks: bool = False,
    usual: PoseNeed | None = None,
) -> PoseForecast:
    """Predict the accuracy of the pose on a route, by the robot's localizer with scans simulated on the map.

    Args:
        field: likelihood field of the map.
        robot: robot file, with its wheels and lidar.
        lidar: section of the lidar in the robot's file.
        start: initial map_T_base.
        route: (n, 2) waypoints on the map, in [m].
        need: required accuracy of the pose at the end.
        docks: True if the robot docks at the end by its own measurements, so that the size of the map's cells
            does not matter.
        usual: accuracy that most places need; `blind_m` is the length of the route on which the pose is less
            accurate (default: `need`).
    """
    localizer = ScanLocalizer(
        field,
        start,
        robot.drive.tread_m,
        robot.odometry.errors,
        START_SIGMA,
        max(MIN_RANGE_SIGMA_M, lidar.sigma_mm / 1e3),
    )
    localizer.expects_echoes = lambda pose: False  # these scans have few where the map shows few
    points = _expected(field, robot, lidar, start).points
    localizer.correct(points)
    length = float(np.hypot(*np.diff(route, axis=0).T).sum())
    step = max(MIN_STEP_M, length / MAX_SCANS)
    before, blind = start, 0.0
    silent, silent_at, unsure = 0.0, None, 0.0
    for pose in _poses(route, start, step):
        turn, way = pose.theta - before.theta, math.hypot(pose.x - before.x, pose.y - before.y)
        rim = 0.5 * robot.drive.tread_m * math.remainder(turn, 2.0 * math.pi)
        localizer.predict(-rim, rim)
        localizer.predict(way, way)
        points = _expected(field, robot, lidar, pose).points
        if len(points) < min(MIN_ECHOES, lidar.beams):
            silent, silent_at = silent + way, silent_at or pose
            unsure = max(unsure, worst_sigmas(localizer.covariance)[0])
        localizer.correct(points)
        spread = repeatability_of(localizer.covariance, localizer.map_error)
        blind += way if undetermined(spread, usual or need) is not None else 0.0
        before = pose
    spread = repeatability_of(localizer.covariance, localizer.map_error)
    shift = NO_SHIFT if docks else depth_shifts(field, points, before)
    return PoseForecast(undetermined(spread, need, shift=shift), blind, length, silent, silent_at, unsure)


def _poses(route: FloatArray, start: Pose2, step: float) -> Iterator[Pose2]:
    """Yield poses on the map along a route, heading in the direction of travel.

    Args:
        route: (n, 2) waypoints on the map, in [m].
        start: initial map_T_base.
        step: distance between two poses, in [m].
    """
    last = start
    for one, other in pairwise(route):
        way = float(np.hypot(*(other - one)))
        for share in np.linspace(0.0, 1.0, max(2, math.ceil(way / step) + 1))[1:]:
            x, y = (one + share * (other - one)).tolist()
            if math.hypot(x - last.x, y - last.y) >= step or (share == 1.0 and other is route[-1]):
                last = Pose2(x, y, math.atan2(y - last.y, x - last.x))
                yield last


def _expected(field: LikelihoodField, robot: RobotFile, lidar: RangeSpec, pose: Pose2) -> ScanBeams:
    """Return the scan that a lidar would measure at a pose map_T_base by the map, without noise."""
    mount = base_T_frame(robot.urdf_text(), robot.lidar_link)
    sensor = Pose2(float(mount[0, 3]), float(mount[1, 3]), math.atan2(mount[1, 0], mount[0, 0]))
    angles = lidar.angles()
    ranges = map_ranges(field, pose.compose(sensor), angles, lidar.reach_m)
    ranges[lidar.masked(angles) | (ranges < lidar.range_min_m)] = np.nan
    return ScanBeams(np.array([sensor.x, sensor.y]), angles + sensor.theta, ranges, lidar.reach_m)
