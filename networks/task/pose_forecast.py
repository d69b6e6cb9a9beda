"""Forecast of the accuracy of the robot's pose at the places of a task, on the map."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.localization.determination import PoseNeed
from handcart.backends.robot.localization.lidar import MIN_ECHOES
from handcart.backends.robot.localization.pose_forecast import PoseForecast, forecast_pose
from handcart.files.errors import Finding
from handcart.files.stages import begin_stage
from handcart.primitives.knowledge.place import ARRIVED_DEG, ARRIVED_MM
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

from .place_room import PLACES_KEY, PlaceRoom
from .task_file import Task

USUAL_NEED = PoseNeed(ARRIVED_MM / 1e3, math.radians(ARRIVED_DEG))


def pose_findings(
    task: Task, robot: RobotFile, model: WorldModel, rooms: Iterable[PlaceRoom]
) -> Iterator[Finding]:
    """Yield warnings about places to which the robot drives and where localization by the lidar will be too
    uncertain.

    There the map's walls do not determine the robot's pose well enough, or the lidar sees too few of them on
    the route to the place.

    Nothing is yielded if the start is unknown, or if the robot does not localize itself by scans.

    Args:
        task: the task, which names places and map.
        robot: the robot's file.
        model: the robot's world model.
        rooms: the places, with the routes from the robot's start.
    """
    begin_stage("uncertainty of the pose at the places")
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
        forecast = forecast_pose(field, robot, lidar, task.knowledge.start, route, need, docks, USUAL_NEED)
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
