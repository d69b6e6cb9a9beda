"""Forecast of the accuracy of the robot's pose at the places of a task, on the map."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.localization.determination import NO_SHIFT, PoseNeed, Undetermined, undetermined
from handcart.backends.robot.localization.lidar import MIN_ECHOES
from handcart.backends.robot.localization.localizations import START_SIGMA
from handcart.backends.robot.localization.pose_covariance import repeatability_of, worst_sigmas
from handcart.files.errors import Finding
from handcart.primitives.knowledge.place import ARRIVED_DEG, ARRIVED_MM
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.navigation.localization.localizer import ScanLocalizer
from handcart.robotics.navigation.localization.scan_matching import LikelihoodField
from handcart.robotics.navigation.localization.start_search import ScanBeams, map_ranges
from handcart.robotics.navigation.localization.surface_depth import depth_shifts
from handcart.robotics.numerics.arrays import FloatArray

from .place_room import PLACES_KEY, PlaceRoom
from .task_file import Task

MIN_STEP_M = 0.3  # between two scans of the forecast
MAX_SCANS = 100
USUAL_NEED = PoseNeed(ARRIVED_MM / 1e3, math.radians(ARRIVED_DEG))
MIN_RANGE_SIGMA_M = 0.01


class PoseForecast(NamedTuple):
    """Expected accuracy of the pose at a place, after the robot has driven there."""

    found: Undetermined | None
    """The direction in which its pose will not be determined as exactly as the place needs it."""
    blind_m: float
    """Length of the route on which the pose is not determined as exactly as places usually need it."""
    route_m: float
    silent_m: float
    """Length of the route on which the lidar gets nearly no echoes: wheels alone carry the pose on there."""
    silent_at: Pose2 | None
    """map_T_base of the first such pose."""
    silent_sigma_m: float
    """Largest sigma of the position there, in its worst direction."""


def pose_findings(
    task: Task, robot: RobotFile, model: WorldModel, rooms: Iterable[PlaceRoom]
) -> Iterator[Finding]:
    """Yield a warning for each place that the robot's lidar does not determine, or whose route is silent.

    Args:
        task: the task, which names places and map.
        robot: the robot.
        model: its world model.
        rooms: the places, with the routes from the robot's start.
    """
    loaded, lidar = task.knowledge.places, robot.range_sensor
    if not task.knowledge.is_start_known:
        return
    if loaded is None or lidar is None or robot.localizer != "scan" or not model.map.occupied.any():
        return
    field = LikelihoodField(model.map)
    for room in rooms:
        if room.way.route is None or not room.driven_to:
            continue
        need = model.places[room.name].need_of(robot.drive.kind)
        docks = model.places[room.name].docks
        route = room.way.route.points
        forecast = forecast_pose(field, robot, lidar, task.knowledge.start, route, need, docks)
        if forecast.found is not None:
            where = f"{forecast.blind_m:.1f} of {forecast.route_m:.1f} m of the way there are as uncertain"
            words = f"place {room.name!r}: {forecast.found.words}, by a lidar of {lidar.reach_m:g} m reach"
            yield loaded.finding((PLACES_KEY, room.name), f"{words}; {where}", at_key=True)
        if forecast.silent_at is not None:
            words = _silence_words(room.name, forecast, forecast.silent_at, lidar)
            yield loaded.finding((PLACES_KEY, room.name), words, at_key=True)


def _silence_words(name: str, forecast: PoseForecast, first: Pose2, lidar: RangeSpec) -> str:
    silent = f"on {forecast.silent_m:.1f} of {forecast.route_m:.1f} m of the route"
    few = f"nearly no echoes, first at ({first.x:.2f}, {first.y:.2f}) m"
    unsure = f"its wheels alone carry its pose on there, up to 3 sigma {3e3 * forecast.silent_sigma_m:.0f} mm"
    least = f"scans need at least {min(MIN_ECHOES, lidar.beams)} beams that return"
    return f"place {name!r}: {silent} a lidar of {lidar.reach_m:g} m reach gets {few}; {unsure}; {least}"


def forecast_pose(
    field: LikelihoodField,
    robot: RobotFile,
    lidar: RangeSpec,
    start: Pose2,
    route: FloatArray,
    need: PoseNeed,
    docks: bool = False,
) -> PoseForecast:
    """Drive a route on the map with the localizer of the robot, and scans as the map has them.

    Args:
        field: likelihood field of the map.
        robot: its wheels and lidar.
        lidar: section of the lidar in the robot's file.
        start: map_T_base.
        route: (n, 2) on the map, in [m].
        need: required accuracy of the pose at the end.
        docks: True if the robot measures the front there itself, so that the map's cells do not matter.
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
        blind += way if undetermined(spread, USUAL_NEED) is not None else 0.0
        before = pose
    spread = repeatability_of(localizer.covariance, localizer.map_error)
    shift = NO_SHIFT if docks else depth_shifts(field, points, before)
    return PoseForecast(undetermined(spread, need, shift=shift), blind, length, silent, silent_at, unsure)


def _poses(route: FloatArray, start: Pose2, step: float) -> Iterator[Pose2]:
    """Poses along a route, no farther than `step` [m] from each other, each heading to where it came from."""
    last = start
    for one, other in pairwise(route):
        way = float(np.hypot(*(other - one)))
        for share in np.linspace(0.0, 1.0, max(2, math.ceil(way / step) + 1))[1:]:
            x, y = (one + share * (other - one)).tolist()
            if math.hypot(x - last.x, y - last.y) >= step or (share == 1.0 and other is route[-1]):
                last = Pose2(x, y, math.atan2(y - last.y, x - last.x))
                yield last


def _expected(field: LikelihoodField, robot: RobotFile, lidar: RangeSpec, pose: Pose2) -> ScanBeams:
    """Return the scan that the map lets expect at a pose."""
    mount = base_T_frame(robot.urdf_text(), robot.lidar_link)
    sensor = Pose2(float(mount[0, 3]), float(mount[1, 3]), math.atan2(mount[1, 0], mount[0, 0]))
    angles = lidar.angles()
    ranges = map_ranges(field, pose.compose(sensor), angles, lidar.reach_m)
    ranges[lidar.masked(angles) | (ranges < lidar.range_min_m)] = np.nan
    return ScanBeams(np.array([sensor.x, sensor.y]), angles + sensor.theta, ranges, lidar.reach_m)
